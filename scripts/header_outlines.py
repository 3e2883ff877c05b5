"""Headers of libraries as clang reads them without the bodies of their functions: what a look at our own code needs.

Of a unit that includes Eigen or Boost clang-tidy looks at every template that the unit brings to life, which takes four
times as long as all the rest. Precompiled by libclang with bodies skipped, the headers declare the same, and nothing of
theirs comes to life; neither do generic lambdas of ours that only they would call, at which clang-tidy looks as written.
"""
import ctypes
import pathlib
import re

# Libraries of templates, and the standard's; not C headers, which some of our files include as `extern "C"`.
WORTH_IT = re.compile(r"<(?:Eigen/|boost/|ceres/|gmock/|gtest/|nlohmann/|opencv2/|[a-z_]+>)")
INCOMPLETE, FOR_SERIALIZATION, SKIP_FUNCTION_BODIES = 0x02, 0x10, 0x40  # clang-c/Index.h, CXTranslationUnit_Flags


def load(version):
    """libclang of clang's major version; None where it is not installed."""
    out = None
    for abi in ("13", "1"):
        try:
            out = out or ctypes.CDLL(f"libclang-{version}.so.{abi}")
        except OSError:
            pass
    if out is None:
        return None
    out.clang_createIndex.restype = ctypes.c_void_p
    out.clang_parseTranslationUnit.restype = ctypes.c_void_p
    out.clang_parseTranslationUnit.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.POINTER(ctypes.c_char_p),
                                               ctypes.c_int, ctypes.c_void_p, ctypes.c_uint, ctypes.c_uint]
    out.clang_saveTranslationUnit.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint]
    out.clang_disposeTranslationUnit.argtypes = out.clang_disposeIndex.argtypes = [ctypes.c_void_p]
    return out


def included_by(sources, root):
    """What our sources, and our headers that they include, include of libraries, in order of name."""
    seen, found, left = set(), set(), [pathlib.Path(source) for source in sources]
    while left:
        path = left.pop()
        if path in seen or not path.is_file():
            continue
        seen.add(path)
        text = path.read_text(encoding="utf-8")
        found.update(name for name in re.findall(r"^#include (<[^>]+>)", text, re.M) if WORTH_IT.match(name))
        left += [root / name for name in re.findall(r'^#include "([^"]+)"', text, re.M)]
    return sorted(found)


def precompile(clang, headers, arguments, place):
    """The precompiled headers' path below the folder `place`; None where they cannot be compiled."""
    source, out = place / "headers.h", place / "headers.pch"
    source.write_text("".join(f"#include {name}\n" for name in headers), encoding="utf-8")
    arguments = [argument.encode() for argument in ["-x", "c++-header", *arguments]]
    index = clang.clang_createIndex(0, 0)
    unit = clang.clang_parseTranslationUnit(index, str(source).encode(), (ctypes.c_char_p * len(arguments))(*arguments),
                                            len(arguments), None, 0, INCOMPLETE | FOR_SERIALIZATION | SKIP_FUNCTION_BODIES)
    failed = unit is None or clang.clang_saveTranslationUnit(unit, str(out).encode(), 0) != 0
    if unit is not None:
        clang.clang_disposeTranslationUnit(unit)
    clang.clang_disposeIndex(index)
    return None if failed else out
