"""Files and places that nobody should give, through the programs.

usage: hostile_inputs.py PROGRAM_DIR [ONLY]

Of each input: exit status 1 and one line on standard error, below 5 s and 500 MiB, and nothing written or changed
outside the folder that --output names. The inputs are made here, by the rules of their formats.
"""
import ctypes
import ctypes.util
import os
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib

MOST_S, MOST_MIB = 5, 500
POSES = ''.join(f'{i} 1 2 3 0 0 0 1\n' for i in range(9))


def yaml_texts():
    key = 'k' * 60
    yield 'comma', ','
    yield 'list_and_comma', '[1],'
    yield 'mark_and_comma', '\ufeff,x'
    yield 'list_in_itself', '&a [*a]'
    yield 'mapping_in_itself', 'a: &a {b: *a}'
    yield 'long_key_in_itself', f'{key}: &a {{{key}: *a}}'
    yield 'aliases_450_deep', 'a0: &a0 [1]\n' + ''.join(f'a{i}: &a{i} [*a{i - 1}]\n' for i in range(1, 450))
    yield 'aliases_that_double', 'a0: &a0 [1]\n' + ''.join(f'a{i}: &a{i} [*a{i - 1},*a{i - 1}]\n' for i in range(1, 40))
    yield 'lists_in_lists', '[' * 20000
    yield 'mappings_in_mappings', '{a: ' * 20000
    yield 'a_table', ',t,x\n0,1,2\n'
    board = '{tag_start_id: 0, tag_size: 0.1, tag_spacing: 0.3, tag_rows: 300, tag_columns: 300}'
    pose = '{position: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0}}'
    yield 'boards', 'bodies:\n' + f'- b: {{is_static: true, pose: {pose}, board: {board}}}\n' * 5000
    yield 'dashes', '- ' * 20000
    yield 'keys_of_keys', '? ' * 20000
    yield 'many_nodes', '[' + '1,' * 300000 + '1]'
    yield 'large_text', 'a: ' + 'x' * 21_000_000
    yield 'documents', '---\n' * 1000
    yield 'zeros', '\0' * 1000
    yield 'same_key', 'a: 1\n' * 100000
    yield 'open_quote', 'a: "' + 'x' * 1_000_000
    yield 'indents', ''.join(' ' * i + 'a:\n' for i in range(3000))


def xml_texts():
    yield 'xml_of_numbers', '<opencv_storage><a>' + '1 ' * 4_000_000 + '</a></opencv_storage>'
    yield 'xml_deep', '<opencv_storage>' + '<a>' * 200_000
    yield 'xml_wide', '<opencv_storage>' + '<a/>' * 300_000 + '</opencv_storage>'
    yield 'xml_open', '<opencv_storage><a'


def tables():
    yield 'many_names', 't,' + ','.join(f'c{i}' for i in range(420_000)) + '\n'
    yield 'index_without_name', ',t,x\n0,1,2\n1,2,3\n'
    yield 'huge_number', 't,x,y,z,qx,qy,qz,qw\n1e400,0,0,0,0,0,0,1\n'
    yield 'stamps_past_all', 't,x,y,z,qx,qy,qz,qw\n4e9,0,0,0,0,0,0,1\n9e18,0,0,0,0,0,0,1\n'
    yield 'long_cell', 't,x\n' + '1' * 10_000_000 + ',2\n'
    yield 'commas', ',\n' * 1_000_000
    yield 'one_column', '1\n' * 1_000_000
    yield 'no_turn', '\n'.join(f'{i} 0 0 0 0 0 0 0' for i in range(5))
    yield 'nans', '\n'.join(f'{i} nan nan nan 0 0 0 1' for i in range(5))
    yield 'points', '\x02\x50' + '\0' * 1000
    yield 'half_of_utf16', '\ufeff1'.encode('utf-16-le').decode('latin1') + '\0'
    yield 'open_quotes', '"' * 100_000 + '\n'
    yield 'zeros', '\0' * 100_000


def record(header, data, length=None):
    fields = b''.join(struct.pack('<I', len(f)) + f for f in header)
    return struct.pack('<I', len(fields)) + fields + struct.pack('<I', len(data) if length is None else length) + data


def bags():
    magic = b'#ROSBAG V2.0\n'
    head = record([b'op=\x03', b'index_pos=' + struct.pack('<Q', 0), b'conn_count=' + struct.pack('<I', 1),
                   b'chunk_count=' + struct.pack('<I', 1)], b' ' * 4000)
    yield 'header_longer_than_bag.bag', magic + b'\x04\0\0\0\x3f\x42\x0f\0\0\0\0\0'
    yield 'header_of_4_gb.bag', magic + b'\xff\xff\xff\xff'
    yield 'record_of_4_gb.bag', magic + record([b'op=\x02'], b'', 0xFFFFFFF0)
    for packing in (b'bz2', b'lz4'):
        yield f'chunk_to_4_gb_{packing.decode()}.bag', magic + head + record(
            [b'op=\x05', b'compression=' + packing, b'size=' + struct.pack('<I', 0xFFFFFFFF)], b'BZh91AY&SY' + b'x' * 6000)
    yield 'index_elsewhere.bag', magic + record(
        [b'op=\x03', b'index_pos=' + struct.pack('<Q', 2**62), b'conn_count=' + struct.pack('<I', 2**31 - 1),
         b'chunk_count=' + struct.pack('<I', 2**31 - 1)], b'')


def mcaps():
    magic = b'\x89MCAP0\r\n'
    for packing in (b'lz4', b'zstd', b''):
        chunk = struct.pack('<QQQI', 0, 1, 2**29, 0) + struct.pack('<I', len(packing)) + packing
        chunk += struct.pack('<Q', 40) + b'x' * 40
        yield f'chunk_to_500_mb_{packing.decode()}.mcap', magic + b'\x06' + struct.pack('<Q', len(chunk)) + chunk + magic
    yield 'record_of_exabytes.mcap', magic + b'\x05' + struct.pack('<Q', 2**63) + magic
    yield 'cut.mcap', magic + b'\x05' + struct.pack('<Q', 100)


def matrix(body):
    return struct.pack('<II', 14, len(body)) + body


def mats():
    head = b'MATLAB 5.0'.ljust(124) + struct.pack('<HH', 0x0100, 0x4D49)

    def numeric(dims, name=b'time'):
        out = struct.pack('<IIII', 6, 8, 6, 0) + struct.pack('<II', 5, 4 * len(dims))
        out += b''.join(struct.pack('<i', d) for d in dims)
        return out + struct.pack('<II', 1, len(name)) + name.ljust(8, b'\0') + struct.pack('<II', 9, 2**32 - 16)

    yield 'dims_of_gigabytes.mat', head + matrix(numeric([2**30, 2]))
    yield 'dims_below_zero.mat', head + matrix(numeric([-1, -1]))
    yield 'many_dims.mat', head + matrix(numeric([2] * 100))
    cell = b''
    for _ in range(200):
        cell = matrix(struct.pack('<IIII', 6, 8, 1, 0) + struct.pack('<IIii', 5, 8, 1, 1) +
                      struct.pack('<II', 1, 0) + cell)
    yield 'cells_in_cells.mat', head + cell
    empty = struct.pack('<II', 14, 0)
    yield 'million_cells.mat', head + matrix(
        struct.pack('<IIII', 6, 8, 1, 0) + struct.pack('<IIii', 5, 8, 1, 1_100_000) + struct.pack('<II', 1, 0) +
        empty * 1_100_000)
    zeros = zlib.compress(struct.pack('<II', 14, 120_000_000) + b'\0' * 120_000_000)
    yield 'zeros_packed.mat', head + struct.pack('<II', 15, len(zeros)) + zeros
    yield 'longer_than_it_is.mat', head + struct.pack('<II', 14, 0xFFFFFF00)


def mat73s(folder):
    """Datasets that announce sizes which nothing fills, by the HDF5 library itself; none where it is missing."""
    names = ['libhdf5_serial.so.103', ctypes.util.find_library('hdf5') or 'none']
    lib = next((lib for lib in map(load, names) if lib), None)
    if lib is None:
        return
    for function in ('H5Fcreate', 'H5Screate_simple', 'H5Pcreate', 'H5Dcreate2', 'H5Gcreate2'):
        getattr(lib, function).restype = ctypes.c_int64
    lib.H5open()
    handle = ctypes.c_int64
    constant = lambda name: handle(handle.in_dll(lib, name).value)
    for name, dims, chunk in (('chunked', (60000, 60000), (1000, 1000)), ('one_chunk', (30000, 30000), (20000, 20000)),
                              ('contiguous', (60000, 60000), None)):
        path = os.path.join(folder, f'{name}73.mat')
        made = handle(lib.H5Pcreate(constant('H5P_CLS_FILE_CREATE_ID_g')))
        lib.H5Pset_userblock(made, ctypes.c_uint64(512))
        file = handle(lib.H5Fcreate(path.encode(), ctypes.c_uint(2), made, handle(0)))
        rank = len(dims)
        space = handle(lib.H5Screate_simple(rank, (ctypes.c_uint64 * rank)(*dims), None))
        plist = handle(lib.H5Pcreate(constant('H5P_CLS_DATASET_CREATE_ID_g')))
        if chunk:
            lib.H5Pset_chunk(plist, rank, (ctypes.c_uint64 * rank)(*chunk))
        group = handle(lib.H5Gcreate2(file, b'data', handle(0), handle(0), handle(0)))
        for place, field in ((file, b'time'), (file, b'vicon'), (group, b't'), (group, b'img')):
            lib.H5Dclose(handle(lib.H5Dcreate2(place, field, constant('H5T_IEEE_F64LE_g'), space, handle(0), plist,
                                               handle(0))))
        lib.H5Gclose(group)
        lib.H5Fclose(file)
        with open(path, 'r+b') as out:
            out.write(b'MATLAB 7.3'.ljust(124) + struct.pack('<HH', 0x0200, 0x4D49))
        yield path


def load(name):
    try:
        return ctypes.CDLL(name)
    except OSError:
        return None


def images():
    def chunk(kind, body):
        return struct.pack('>I', len(body)) + kind + body + struct.pack('>I', zlib.crc32(kind + body))

    side = 32768
    rows = zlib.compress(b'\0' * 100_000)
    for name, width, height in (('square', side, side), ('line', 2**31 - 1, 1), ('huge', 2**31 - 1, 2**31 - 1)):
        yield f'{name}.png', b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 0, 0, 0, 0)) + \
            chunk(b'IDAT', rows) + chunk(b'IEND', b'')
    yield 'no_rows.png', b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', 64, 64, 8, 0, 0, 0, 0)) + \
        chunk(b'zTXt', b'x\0\0' + zlib.compress(b'\0' * 10_000_000)) + chunk(b'IEND', b'')
    entries = [(256, 4, side), (257, 4, side), (258, 3, 8), (259, 3, 1), (262, 3, 1), (273, 4, 8), (277, 3, 1),
               (278, 4, side), (279, 4, 2**31)]
    yield 'square.tiff', b'II*\0' + struct.pack('<IH', 8, len(entries)) + b''.join(
        struct.pack('<HHII', tag, kind, 1, value) for tag, kind, value in entries) + struct.pack('<I', 0)
    yield 'square.bmp', b'BM' + struct.pack('<IHHI', 100, 0, 0, 54) + struct.pack('<IiiHHIIiiII', 40, side, side, 1, 8,
                                                                                   0, 0, 0, 0, 0, 0)
    yield 'square.pgm', b'P5 32768 32768 255\n' + b'x' * 40
    yield 'square.jpg', b'\xff\xd8\xff\xc0\0\x0b\x08\xff\xff\xff\xff\1\1\x11\0\xff\xda\0\x08\1\1\0\0\x3f\0x\xff\xd9'
    yield 'negative.pgm', b'P5 -5 -5 255\n' + b'x' * 40


def videos():
    yield 'square.y4m', b'YUV4MPEG2 W32768 H32768 F30:1 Ip C420\n' + b'FRAME\nx' * 50
    yield 'no_frames.y4m', b'YUV4MPEG2 W64 H64 F30:1 Ip C420\n'
    yield 'cut.mp4', b'\0\0\0\x20ftypisom\0\0\2\0isomiso2avc1mp41\xff\xff\xff\xffmoov' + b'x' * 500
    yield 'cut.avi', b'RIFF\xff\xff\xff\x7fAVI LIST\xff\xff\xff\x7fhdrlavih' + b'x' * 200
    yield 'atoms.mp4', b'\0\0\0\x18ftypisom\0\0\2\0isomavc1' + b'\0\0\0\x08moov' * 10000


def inputs(work):
    """Name, program and arguments of each."""
    def file(name, content):
        path = os.path.join(work, 'in', name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'wb') as out:
            out.write(content.encode('utf-8', 'surrogateescape') if isinstance(content, str) else content)
        return path

    def estimate(*more):
        return ['tagtwist_estimate', '--dataset', os.path.join(work, 'rec'), '--use_detections', *more]

    def recording(path):
        return ['tagtwist_estimate', '--dataset', path]

    good = file('good.tum', POSES)
    flags = ('--config', '--camera_file', '--map')
    for i, (name, text) in enumerate([*yaml_texts(), *xml_texts()]):
        path = file(f'{name}.yaml', text)
        flag = '--camera_file' if name.startswith('xml') else '--map' if name == 'boards' else flags[i % 3]
        yield f'{flag} {name}', estimate(flag, path)
    for i, (name, text) in enumerate(tables()):
        path = file(f'{name}.csv', text)
        programs = (estimate('--ground_truth', path), ['tagtwist_compare', path, '--ground_truth', good],
                    ['tagtwist_simulate', '--trajectory', path])
        yield f'table {name}', programs[i % 3]
    for name, text in (('id', 't,id,u1,v1,u2,v2,u3,v3,u4,v4\n0,1e30,1,1,2,1,2,2,1,2\n'),
                       ('corner', 't,id,u1,v1,u2,v2,u3,v3,u4,v4\n' + ''.join(
                           f'{t},0,1e308,1,2,1e308,-1e308,2,1,2\n' for t in range(4)))):
        file(f'corners_{name}/detections.csv', text)
        yield f'detections {name}', recording(os.path.join(work, 'in', f'corners_{name}')) + ['--use_detections']
    for name, content in [*bags(), *mcaps(), *mats(), *videos(), ('cut.db3', b'SQLite format 3\0' + b'\xff' * 4000)]:
        yield name, recording(file(name, content))
    os.makedirs(os.path.join(work, 'in'), exist_ok=True)
    for path in mat73s(os.path.join(work, 'in')):
        yield os.path.basename(path), recording(path)
    for name, content in images():
        file(f'images_{name}/{name}', content)
        file(f'images_{name}/timestamps.csv', f't,file\n0,{name}\n1,{name}\n')
        yield f'image {name}', recording(os.path.join(work, 'in', f'images_{name}'))
    for name, target in (('zero', '/dev/zero'), ('above', '../../../../../../dev/zero'), ('folder', '.')):
        file(f'place_{name}/timestamps.csv', f't,file\n0,{target}\n1,{target}\n')
        yield f'image at {target}', recording(os.path.join(work, 'in', f'place_{name}'))
    for place in ('/dev/zero', '/dev/full', work):
        for flag in ('--config', '--camera_file', '--map', '--ground_truth'):
            yield f'{flag} {os.path.basename(place)}', estimate(flag, place)
    pipe = os.path.join(work, 'in', 'pipe')
    os.mkfifo(pipe)
    yield 'a pipe as recording', recording(pipe)
    yield 'a pipe as camera', recording('camera:' + pipe) + ['--sliding_window']
    yield 'a pipe as truth', estimate('--ground_truth', pipe)
    file('deep/summary.json', '[' * 1_000_000)
    yield 'summary of lists in lists', ['tagtwist_compare', '--collect', os.path.join(work, 'in', 'deep')]
    yield 'states of nothing', ['tagtwist_compare', file('states.csv', 't,sigma_x\n' + '1,nan\n' * 10)]


def tree(folder):
    """Names and digests of all below it."""
    out = {}
    for root, folders, files in os.walk(folder):
        for name in folders:
            out[os.path.join(root, name)] = 'folder'
        for name in files:
            path = os.path.join(root, name)
            status = os.lstat(path)
            out[path] = (status.st_size, status.st_mtime_ns, status.st_ino)
    return out


def run(command, work, address_space=None):
    """Exit status, standard error, seconds of the wall and of the processor, and peak MiB."""
    def bound():
        if address_space:
            resource.setrlimit(resource.RLIMIT_AS, (address_space, address_space))
    environment = dict(os.environ, TMPDIR=os.path.join(work, 'tmp'), HOME=os.path.join(work, 'home'))
    start = time.monotonic()
    with tempfile.TemporaryFile() as err:
        process = subprocess.Popen(command, cwd=os.path.join(work, 'cwd'), env=environment, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=err, preexec_fn=bound)
        try:
            while True:
                pid, status, usage = os.wait4(process.pid, os.WNOHANG)
                if pid:
                    break
                if time.monotonic() - start > 30:
                    process.kill()
                time.sleep(0.004)
        finally:
            process.returncode = 0
        seconds = time.monotonic() - start
        err.seek(0)
        text = err.read().decode('utf-8', 'replace')
    code = os.WEXITSTATUS(status) if os.WIFEXITED(status) else -os.WTERMSIG(status)
    return code, text, seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def little_memory(programs, work):
    """What a run does in 2 GB of addresses, and in ever less: it works, or says so in one line."""
    faults = []
    rendered = os.path.join(work, 'flight')
    subprocess.run([os.path.join(programs, 'tagtwist_simulate'), '--output', rendered, '--duration', '1', '--rate', '12'],
                   check=True, stdout=subprocess.DEVNULL)
    for space in (2_000_000 * 1024, 700 << 20, 500 << 20, 400 << 20):
        code, text, *_ = run([os.path.join(programs, 'tagtwist_estimate'), '--dataset', rendered, '--output',
                              os.path.join(work, 'out')], work, space)
        # What the loader or a library cannot get before main begins is theirs to tell.
        if code not in (0, 1, 127) or code == 1 and text.count('\n') != 1:
            faults.append(f'with {space >> 20} MiB of addresses')
            print(f'{faults[-1]}: exit status {code}: {text[:300]!r}')
        if space >= 2_000_000 * 1024 and code != 0:
            print(f'with {space >> 20} MiB of addresses: {text[:300]!r}')
        shutil.rmtree(os.path.join(work, 'out'), ignore_errors=True)
    shutil.rmtree(rendered)
    return faults


def main():
    programs, only = os.path.abspath(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else ''
    work = tempfile.mkdtemp(prefix='tagtwist_hostile_')
    faults, count, slowest, largest = [], 0, 0, 0
    try:
        for folder in ('cwd', 'tmp', 'home'):
            os.mkdir(os.path.join(work, folder))
        subprocess.run([os.path.join(programs, 'tagtwist_simulate'), '--output', os.path.join(work, 'rec'),
                        '--images=false', '--duration', '1'], check=True, stdout=subprocess.DEVNULL)
        if not only:
            faults += little_memory(programs, work)
        for name, command in inputs(work):
            if only not in name:
                continue
            output = [] if command[0] == 'tagtwist_compare' else ['--output', os.path.join(work, 'out')]
            before = tree(work)
            code, text, wall_s, cpu_s, mib = run([os.path.join(programs, command[0]), *command[1:], *output], work)
            count += 1
            slowest, largest = max(slowest, cpu_s), max(largest, mib)
            wrong = []
            if code != 1:
                wrong.append(f'exit status {code}')
            if text.count('\n') != 1 or not text.endswith('\n') or len(text) > 4000:
                wrong.append(f'{text.count(chr(10))} lines')
            # Of a crowded machine the processor's time counts; what only waits is held to the wall's.
            if min(wall_s, cpu_s) > MOST_S or wall_s > 5 * MOST_S:
                wrong.append(f'{wall_s:.1f} s, of the processor {cpu_s:.1f} s')
            if mib > MOST_MIB:
                wrong.append(f'{mib:.0f} MiB')
            after = {path: kind for path, kind in tree(work).items()
                     if path != os.path.join(work, 'out') and not path.startswith(os.path.join(work, 'out') + os.sep)}
            if after != before:
                wrong.append('wrote outside its output: ' + ', '.join(
                    sorted(p for p in {*after, *before} if after.get(p) != before.get(p)))[:200])
            if wrong or only:
                print(f'{name}: {"; ".join(wrong) or "as it should"}: {text[:300]!r}')
            if wrong:
                faults.append(name)
            shutil.rmtree(os.path.join(work, 'out'), ignore_errors=True)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    print(f'{count} inputs, {len(faults)} answered otherwise than in one line, with 1, in bounds; '
          f'at most {slowest:.2f} s of a processor and {largest:.0f} MiB')
    return 1 if faults or count < 58 and not only else 0


if __name__ == '__main__':
    sys.exit(main())
