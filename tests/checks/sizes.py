"""Holds the sizes of the sources below a folder: python3 sizes.py ROOT.

A folder has at most 25 files of code, a file at most 300 lines, a function at most 60, and 95 of 100 functions of the
programs and libraries at most 30. Prints a line for each that is larger and exits with 1; with 77 without ctags."""
import collections
import json
import pathlib
import shutil
import subprocess
import sys

MOST_FILES, MOST_LINES, MOST_FUNCTION, MOST_P95 = 25, 300, 60, 30
LIBRARIES = ("frontend", "residuals", "estimator", "apps")


def sources(root):
    for top in LIBRARIES + ("bench", "tests"):
        yield from sorted(p for p in (root / top).rglob("*") if p.suffix in (".cc", ".h"))


def function_lines(files):
    """(lines, file, line, name) of each function that has a body."""
    told = subprocess.run(
        ["ctags", "--output-format=json", "--languages=C++", "--langmap=C++:.cc.h", "--kinds-C++=f",
         "--fields=+ne", "-L", "-", "-f", "-"],
        input="\n".join(map(str, files)), capture_output=True, text=True, check=True).stdout
    for line in told.splitlines():
        tag = json.loads(line)
        if "end" in tag:
            yield tag["end"] - tag["line"] + 1, tag["path"], tag["line"], tag["name"]


def faults(root):
    files = list(sources(root))
    if not files:
        yield f"{root}: holds no sources"
        return
    for folder, count in collections.Counter(p.parent for p in files).items():
        if count > MOST_FILES:
            yield f"{folder}: {count} files, at most {MOST_FILES}"
    for path in files:
        lines = len(path.read_text(encoding="utf-8").splitlines())
        if lines > MOST_LINES:
            yield f"{path}: {lines} lines, at most {MOST_LINES}"
    functions = list(function_lines(files))
    for lines, path, line, name in functions:
        if lines > MOST_FUNCTION:
            yield f"{path}:{line}: {name} has {lines} lines, at most {MOST_FUNCTION}"
    tops = tuple(str(root / top) for top in LIBRARIES)
    sizes = sorted(lines for lines, path, _, _ in functions if path.startswith(tops))
    if sizes and sizes[(95 * len(sizes)) // 100] > MOST_P95:
        yield f"{root}: 95 of 100 functions have up to {sizes[(95 * len(sizes)) // 100]} lines, at most {MOST_P95}"


def main():
    if shutil.which("ctags") is None:
        print("universal-ctags is not installed (scripts/setup test)")
        return 77
    found = list(faults(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
