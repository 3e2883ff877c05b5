#!/usr/bin/env python3
"""Names of the project and of the standard library are there by what a file includes itself.

Builds compile several sources as one unit, in which a source sees what the ones before it include. So that each
compiles alone, every name that a header declares is reached from a file that uses it by #include lines, and so is the
header of each std:: name. Prints one line a fault and exits 1; 77 without universal-ctags.
"""
import json
import os
import re
import shutil
import subprocess
import sys

FOLDERS = ['frontend', 'residuals', 'estimator', 'apps', 'bench', 'tests']
NAMESPACE_KINDS = {'class', 'struct', 'enum', 'function', 'prototype', 'typedef', 'variable', 'macro', 'alias'}

# Where a standard name is declared. Names that any header brings (size_t, move, pair) are left out.
STANDARD = {
    'algorithm': 'sort stable_sort min max minmax clamp all_of any_of none_of find_if count_if lower_bound upper_bound '
                 'nth_element reverse transform unique remove_if copy_if max_element min_element partition fill',
    'array': 'array', 'atomic': 'atomic', 'bitset': 'bitset', 'chrono': 'chrono',
    'cmath': 'sqrt hypot sin cos tan atan2 atan acos asin exp log log10 pow floor ceil lround isfinite isnan isinf fmod',
    'condition_variable': 'condition_variable', 'cstring': 'memcpy memcmp strerror strlen', 'deque': 'deque',
    'filesystem': 'filesystem', 'fstream': 'ifstream ofstream', 'functional': 'function', 'future': 'future async',
    'iostream': 'cout cerr cin', 'iterator': 'back_inserter distance', 'limits': 'numeric_limits', 'list': 'list',
    'map': 'map multimap', 'memory': 'unique_ptr shared_ptr make_unique make_shared weak_ptr',
    'mutex': 'mutex lock_guard unique_lock', 'numeric': 'accumulate iota inner_product', 'optional': 'optional nullopt',
    'queue': 'queue priority_queue', 'random': 'mt19937 mt19937_64 normal_distribution uniform_real_distribution '
                                               'uniform_int_distribution',
    'regex': 'regex', 'set': 'set multiset', 'sstream': 'ostringstream istringstream stringstream',
    'string': 'string to_string stod stoi', 'string_view': 'string_view', 'thread': 'thread this_thread',
    'tuple': 'tuple tie make_tuple', 'type_traits': 'is_same_v enable_if_t decay_t conditional_t',
    'unordered_map': 'unordered_map', 'unordered_set': 'unordered_set', 'variant': 'variant', 'vector': 'vector',
}
HEADER_OF = {name: header for header, names in STANDARD.items() for name in names.split()}

# What a foreign header includes, on every supported standard library.
BRINGS = [
    (r'Eigen/|unsupported/Eigen', 'algorithm array cmath complex cstring functional limits string string_view '
                                  'type_traits tuple'),
    (r'ceres/', 'Eigen/Core map memory set string vector'),
    (r'opencv2/', 'Eigen/none algorithm array cmath map memory string vector functional limits string_view'),
    (r'gtest/|gmock/', 'algorithm functional iostream iterator limits map memory set sstream string string_view tuple '
                       'type_traits utility vector'),
    (r'pybind11/', 'array functional map memory string string_view tuple type_traits unordered_map unordered_set vector'),
    (r'nlohmann/', 'algorithm array functional limits map memory optional string string_view tuple type_traits vector'),
    (r'yaml-cpp/', 'map memory sstream string vector'),
    (r'benchmark/', 'algorithm map memory set string vector'),
    (r'rosbag/|fastcdr/|glog/|gflags/', 'string vector map sstream'),
    (r'string$|filesystem$|sstream$|fstream$|iostream$', 'string string_view'),
    (r'map$|set$|functional$', 'tuple'),
    (r'chrono$|thread$|future$|condition_variable$|mutex$', 'limits'),
]

# A template finds these in the namespace of its argument.
FOUND_BY_ARGUMENT = {'Difference', 'EnumNames'}
# Forward declarations, and names taken over from another namespace.
NAMED_HERE = r'\b(?:(?:class|struct) |using [\w:]+::)(\w+);'


def code_of(text):
    """The text without comments and literals."""
    text = re.sub(r'\b(INSTANTIATE_)?TEST\w*\(\w+, \w+', ' ', text)
    return re.sub(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', ' ', text,
                  flags=re.S)


def read(root):
    files = {}
    for folder in FOLDERS:
        for at, _, names in os.walk(os.path.join(root, folder)):
            for name in names:
                if name.endswith(('.h', '.cc')) and 'installed' not in at:
                    path = os.path.join(at, name)
                    with open(path, encoding='utf-8') as file:
                        files[os.path.relpath(path, root)] = file.read()
    return files


def declared(root, paths):
    """By file: all names, and those at the level of a namespace."""
    listing = subprocess.run(
        ['ctags', '--output-format=json', '--fields=+K', '--kinds-C++=+pxlvzUAZN', '--language-force=C++', '-f', '-', '-L', '-'],
        input='\n'.join(paths), capture_output=True, text=True, check=True, cwd=root).stdout
    everything, outer = {p: set() for p in paths}, {p: set() for p in paths}
    for line in listing.splitlines():
        tag = json.loads(line)
        everything[tag['path']].add(tag['name'])
        inner = tag.get('scopeKind') not in (None, 'namespace') or '__anon' in tag.get('scope', '')
        if tag['kind'] in NAMESPACE_KINDS and not inner:
            outer[tag['path']].add(tag['name'])
    return everything, outer


def reached(path, includes, memo):
    """The project's files and the foreign headers that a file includes, directly or not."""
    if path not in memo:
        memo[path] = ({path}, set())
        ours, foreign = {path}, set()
        for include in includes[path]:
            if include in includes:
                more = reached(include, includes, memo)
                ours |= more[0]
                foreign |= more[1]
            else:
                foreign.add(include)
        memo[path] = (ours, foreign)
    return memo[path]


def with_brought(foreign):
    out = set(foreign)
    for header in foreign:
        for pattern, brought in BRINGS:
            if re.match(pattern, header):
                out |= set(brought.split())
    return out


def faults(root):
    files = read(root)
    includes = {p: re.findall(r'^#include ["<]([^">]+)[">]', text, re.M) for p, text in files.items()}
    everything, outer = declared(root, sorted(files))
    headers_of = {}
    for path, names in outer.items():
        if path.endswith('.h'):
            for name in names:
                headers_of.setdefault(name, set()).add(path)
    memo, out = {}, []
    for path in sorted(files):
        ours, foreign = reached(path, includes, memo)
        code = code_of(files[path])
        known = FOUND_BY_ARGUMENT.union(re.findall(NAMED_HERE, code), *(everything[p] for p in ours))
        for name in sorted(set(re.findall(r'(?<![\w.>:])(?:tagtwist::)?([A-Za-z_]\w+)', code)) - known):
            if name in headers_of:
                out.append(f'{path}: uses {name} without including {min(headers_of[name])}')
        there = with_brought(foreign)
        for name in sorted(set(re.findall(r'\bstd::(\w+)', code))):
            header = HEADER_OF.get(name)
            if header and header not in there:
                out.append(f'{path}: uses std::{name} without including <{header}>')
    return out


def main():
    if not shutil.which('ctags'):
        print('skipped: universal-ctags is not installed')
        return 77
    found = faults(sys.argv[1])
    print('\n'.join(found))
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main())
