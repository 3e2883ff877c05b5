"""Runs units.py on small trees: one fault at a time must be named, and sources that can be one unit pass."""
import pathlib
import shutil
import sys
import tempfile

import units


def kept(code):
    return f"namespace tagtwist {{\nnamespace {{\n{code}\n}}\n}}\n"


ROOM = "estimator/solve"
CASES = {
    "different names": ({f"{ROOM}/a.cc": kept("int kA = 1;"), f"{ROOM}/b.cc": kept("int kB = 1;")}, None),
    "a constant twice": ({f"{ROOM}/a.cc": kept("const int kA = 1;"), f"{ROOM}/b.cc": kept("const int kA = 1;")},
                         "estimator/solve/b.cc: kA is in the unnamed namespace of a.cc too"),
    "a type twice": ({f"{ROOM}/a.cc": kept("struct Row {};"), f"{ROOM}/b.cc": kept("class Row {};")}, "Row is in"),
    "a type and a function": ({f"{ROOM}/a.cc": kept("int Row(int a) { return 1; }"),
                               f"{ROOM}/b.cc": kept("template <int n>\nstruct Row {};")},
                              "estimator/solve/b.cc: Row is in the unnamed namespace of a.cc too"),
    "a function twice": ({f"{ROOM}/a.cc": kept("int F(int a, double b) { return 1; }"),
                          f"{ROOM}/b.cc": kept("int F(int c, double d) { return 2; }")}, "F is in"),
    "an overload": ({f"{ROOM}/a.cc": kept("int F(int a) { return 1; }"),
                     f"{ROOM}/b.cc": kept("int F(double a) { return 2; }")}, None),
    "another room": ({f"{ROOM}/a.cc": kept("int kA = 1;"), "estimator/batch/b.cc": kept("int kA = 1;")}, None),
    "a local of that name": ({f"{ROOM}/a.cc": kept("const int kA = 1;"),
                              f"{ROOM}/b.cc": kept("int F() {\n  const int kA = 2;\n  return kA;\n}")},
                             "estimator/solve/b.cc: a local kA shadows that of a.cc"),
    "a test": ({"tests/estimator/a_test.cc": "namespace tagtwist::a_test {\n}\n"}, None),
    "a test in the library's namespace": ({"tests/estimator/a_test.cc": "namespace tagtwist {\n}\n"},
                                          "tests/estimator/a_test.cc: has no namespace tagtwist::a_test"),
}


def main():
    if shutil.which("ctags") is None:
        return 77
    failed = 0
    for name, (files, expected) in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            for file, text in files.items():
                path = pathlib.Path(folder) / file
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            told = list(units.faults(folder))
        if not (told == [] if expected is None else len(told) == 1 and expected in told[0]):
            print(f"{name}: expected {expected}, got {told}")
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
