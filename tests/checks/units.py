"""Holds sources of a folder to names that let them be one unit (TAGTWIST_UNITY): python3 units.py ROOT.

What a source keeps in its unnamed namespace has a name that no other source of its folder uses for the same purpose: no
other variable, type or function of the same parameters, and no local constant that would shadow it. Tests have a namespace
of their own each, named like the file. Prints a line for each fault and exits with 1; with 77 without ctags."""
import collections
import json
import pathlib
import re
import shutil
import subprocess
import sys

ROOMS = ("frontend", "residuals", "estimator", "apps", "tests/support")
APART = ("apps", "tests")  # sources of programs of their own, and tests
OVERLOADED = ("function", "typedef", "alias")


def tags_of(files):
    told = subprocess.run(
        ["ctags", "--output-format=json", "--language-force=C++", "--kinds-C++=cdefgstuvl", "--fields=+KSt", "-L", "-",
         "-f", "-"], input="\n".join(map(str, files)), capture_output=True, text=True, check=True).stdout
    return map(json.loads, told.splitlines())


def parameters(signature):
    """The types of a signature, without the parameters' names and defaults."""
    types = [re.sub(r"\s*=.*", "", part).strip() for part in signature.strip("() const").split(",")]
    return ",".join(re.sub(r"([\w>*&])\s*\b\w+$", r"\1", part) if " " in part else part for part in types)


def kept(tag):
    """What a tag of an unnamed namespace may not share, or None of another tag."""
    if not tag.get("scope", "").rpartition("::")[2].startswith("__anon") or tag.get("scopeKind") != "namespace":
        return None
    if tag["kind"] in OVERLOADED:
        return tag["name"], parameters(tag["signature"]) if "signature" in tag else tag.get("typeref")
    return tag["name"], None


def faults(root):
    root = pathlib.Path(root)
    files = [p for room in ROOMS for p in sorted((root / room).rglob("*.cc")) if str(p.parent.relative_to(root)) not in APART]
    seen, constants, kinds = (collections.defaultdict(dict) for _ in range(3))
    local = []
    for tag in tags_of(files):
        path = pathlib.Path(tag["path"])
        room, file = str(path.parent.relative_to(root)), path.name
        if tag["kind"] == "local":
            if "__anon" in tag.get("scope", ""):  # elsewhere the compiler does not call it shadowed
                local.append((room, file, tag["name"]))
            continue
        key = kept(tag)
        if key is None:
            continue
        if tag["kind"] == "variable":
            constants[room].setdefault(tag["name"], file)
        other = seen[room].setdefault(key, file)
        same_alias = tag["kind"] in ("typedef", "alias")
        kind = "function" if tag["kind"] == "function" else "type or variable"  # only functions share a name
        other_kind, first = kinds[room].setdefault(tag["name"], (kind, file))
        if (other != file and not same_alias) or (kind != other_kind and first != file):
            yield f"{room}/{file}: {tag['name']} is in the unnamed namespace of {other if other != file else first} too"
    for room, file, name in sorted(set(local)):
        if constants[room].get(name, file) != file:
            yield f"{room}/{file}: a local {name} shadows that of {constants[room][name]}"
    for path in sorted((root / "tests").rglob("*_test.cc")):
        if not re.search(rf"^namespace tagtwist::(\w+::)?{path.stem} {{$", path.read_text(encoding="utf-8"), re.M):
            yield f"{path.relative_to(root)}: has no namespace tagtwist::{path.stem}"


def main():
    if shutil.which("ctags") is None:
        print("universal-ctags is not installed (scripts/setup test)")
        return 77
    found = list(faults(sys.argv[1]))
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
