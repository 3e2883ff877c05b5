#!/bin/sh
# streams_test.js and several_test.js with their packages, which npm brings into the folder of the build once: PROGRAMS FOLDER. Exit status 77
# where there is no npm, or no way to the packages.
set -eu
here=$(dirname "$0")
command -v npm >/dev/null || { echo "skipped: npm is not installed"; exit 77; }
if [ ! -d "$2/node_modules/ws" ]; then
  mkdir -p "$2"
  cp "$here/package.json" "$2/package.json"
  (cd "$2" && timeout 60 npm install --no-audit --no-fund >npm.log 2>&1) ||
    { echo "skipped: npm does not bring the packages ($2/npm.log)"; exit 77; }
fi
export NODE_PATH="$2/node_modules"
node "$here/streams_test.js" "$1"
exec node "$here/several_test.js" "$1"
