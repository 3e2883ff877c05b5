"""Runs sizes.py on small trees: one fault at a time must be named, and sources of good size pass."""
import pathlib
import shutil
import sys
import tempfile

import sizes


def function(name, lines):
    return f"int {name}() {{\n" + "  // .\n" * (lines - 3) + "  return 0;\n}\n"


CASES = {
    "a good tree": ({"a.cc": function("A", 60), **{f"f{i}.cc": function(f"F{i}", 30) for i in range(24)}}, None),
    "files of a folder": ({f"f{i}.cc": "" for i in range(26)}, "26 files"),
    "lines of a file": ({"a.cc": "\n" * 301}, "301 lines"),
    "lines of a function": ({"a.cc": function("Long", 61), "b.cc": "".join(function(f"F{i}", 5) for i in range(40))},
                            "Long has 61 lines"),
    "most functions": ({"a.cc": "".join(function(f"F{i}", 31 if i < 2 else 5) for i in range(20))}, "up to 31 lines"),
    "nothing": ({}, "no sources"),
}


def main():
    if shutil.which("ctags") is None:
        return 77
    failed = 0
    for name, (files, expected) in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            room = pathlib.Path(folder) / "estimator" / "room"
            room.mkdir(parents=True)
            for file, text in files.items():
                (room / file).write_text(text)
            told = list(sizes.faults(pathlib.Path(folder)))
        if not (told == [] if expected is None else len(told) == 1 and expected in told[0]):
            print(f"{name}: expected {expected}, got {told}")
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
