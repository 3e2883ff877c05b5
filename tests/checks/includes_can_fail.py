"""Runs includes.py on small trees: one fault at a time must be named, and sources that include what they use pass."""
import pathlib
import shutil
import sys
import tempfile

import includes

TRIM = "#pragma once\n#include <string>\nnamespace tagtwist {\nstd::string Trim(const std::string& text);\n}\n"
USE = "std::string Cut() { return Trim(std::string()); }\n"
CASES = {
    "included itself": ({"trim.h": TRIM, "a.cc": f'#include "estimator/trim.h"\n{USE}'}, None),
    "included by another": ({"trim.h": TRIM, "b.h": '#include "estimator/trim.h"\n',
                             "a.cc": f'#include "estimator/b.h"\n{USE}'}, None),
    "a name not included": ({"trim.h": TRIM, "a.cc": f"#include <string>\n{USE}"},
                            "estimator/a.cc: uses Trim without including estimator/trim.h"),
    "a standard name not included": ({"a.cc": "std::vector<int> a;\n"},
                                     "estimator/a.cc: uses std::vector without including <vector>"),
    "said in a comment": ({"trim.h": TRIM, "a.cc": '// Trim\nconst char* t = "std::vector Trim";\n'}, None),
    "a member of another": ({"trim.h": TRIM, "a.cc": "struct B { int Trim; };\nint Cut(B b) { return b.Trim; }\n"}, None),
    "declared ahead": ({"c.h": "class Trimmer {};\n", "a.cc": "class Trimmer;\nTrimmer* t = nullptr;\n"}, None),
}


def main():
    if shutil.which("ctags") is None:
        return 77
    failed = 0
    for name, (files, expected) in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            room = pathlib.Path(folder) / "estimator"
            room.mkdir(parents=True)
            for file, text in files.items():
                (room / file).write_text(text)
            told = includes.faults(folder)
        if told != ([expected] if expected else []):
            print(f"{name}: expected {expected}, got {told}")
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
