"""Reads the ELF headers of programs and static libraries: python3 hardened.py FILE...

Each program must be position independent, bound at its start (full RELRO), have no executable stack, and no RPATH or
RUNPATH, whose empty entries would be the folder that it is started in; it guards its stacks and asks the C library's
checking calls (FORTIFY). Of a library (*.a) each object must be made for indirect jumps that are checked (CET), where
the processor is one that has this; the system's own start of a program need not be. Prints a line for each fault and
exits with 1; with 77 without readelf."""
import platform
import re
import shutil
import subprocess
import sys


def readelf(flag, path):
    return subprocess.run(["readelf", "-W", flag, path], capture_output=True, text=True, check=True).stdout


def faults_of_library(path):
    if platform.machine() != "x86_64":
        return
    notes = readelf("-n", path)
    objects = notes.count("File: ")
    if notes.count("IBT, SHSTK") < max(objects, 1):
        yield f"only {notes.count('IBT, SHSTK')} of {objects} objects are made for checked jumps"


def faults(path):
    if path.endswith(".a"):
        yield from faults_of_library(path)
        return
    dynamic, headers = readelf("-d", path), readelf("-l", path)
    if "RPATH" in dynamic or "RUNPATH" in dynamic:
        yield "has a RUNPATH"
    if "BIND_NOW" not in dynamic and "Flags: NOW" not in dynamic:
        yield "is not bound at its start"
    if "GNU_RELRO" not in headers:
        yield "has no RELRO"
    stack = [line for line in headers.splitlines() if "GNU_STACK" in line]
    if not stack or " RWE" in stack[0]:
        yield "has an executable stack"
    if "Type:" in readelf("-h", path) and "DYN" not in readelf("-h", path):
        yield "is not position independent"
    symbols = readelf("--dyn-syms", path)
    if "__stack_chk_fail" not in symbols:
        yield "does not guard its stacks"
    if not re.search(r"__(mem|str|v?f?s?n?printf|read)\w*_chk", symbols):
        yield "has none of the C library's checking calls"


def main(paths):
    if shutil.which("readelf") is None:
        return 77
    told = [f"{path}: {fault}" for path in paths for fault in faults(path)]
    print("\n".join(told))
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
