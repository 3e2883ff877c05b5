"""Set-ups with one mistake each, and right ones, through tagtwist_simulate and tagtwist_estimate: what is named.

usage: set_up_mistakes.py PROGRAM_DIR [DRAWS [RIGHT_DRAWS [SEED [ONLY]]]]

Of each mistake, in each of its draws, the cause must be named on the terminal (nine of ten over all of them); of right
set-ups nothing may be told. The recordings are corners, drawn from the simulator: flight, camera, lens, noise and map
are another in each draw. Only the family's mistake needs images.
"""
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

LOOKS_DOWN = 'rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1], translation_m: [0.04, 0, -0.03]'


class Draw:
    """A set-up and what is recorded with it; a mistake changes `told`, or the recording's files."""

    def __init__(self, programs, folder, seed):
        self.programs, self.folder = programs, folder
        self.rng = rng = random.Random(seed)
        self.seed = seed
        fx = rng.uniform(300, 480)
        self.camera = dict(width=rng.choice([640, 752]), height=480, fx=fx, fy=fx * rng.uniform(0.995, 1.005))
        self.camera['cx'] = self.camera['width'] / 2 + rng.uniform(-15, 15)
        self.camera['cy'] = 240 + rng.uniform(-15, 15)
        self.lens = [rng.uniform(-0.3, -0.2), rng.uniform(0.05, 0.09), 0.0, 0.0] if rng.random() < 0.5 else None
        self.rows, self.columns = rng.randint(6, 9), rng.randint(4, 5)
        self.size = rng.uniform(0.1, 0.2)
        self.row_gap, self.column_gap = (self.size * rng.uniform(0.5, 1) for _ in range(2))
        self.flight = rng.choice(['figure8', 'agile', 'circle'])
        self.noise = rng.uniform(0.1, 0.3)
        self.height = rng.uniform(5, 8) * self.size
        self.line_time = 0.0
        self.seconds, self.rate = 6, 30
        self.images = False
        self.told = None
        self.truth = None
        self.more = []

    def grid(self, rows=None, columns=None, size=None, row_gap=None, column_gap=None):
        return dict(rows=rows or self.rows, columns=columns or self.columns, size=size or self.size,
                    row_gap=self.row_gap if row_gap is None else row_gap,
                    column_gap=self.column_gap if column_gap is None else column_gap)

    @staticmethod
    def tags_of(grid, scale=1.0):
        out = []
        for column in range(grid['columns']):
            for row in range(grid['rows']):
                x = row * (grid['size'] + grid['row_gap']) + grid['size'] / 2
                y = column * (grid['size'] + grid['column_gap']) + grid['size'] / 2
                out.append([len(out), grid['size'] * scale, x * scale, y * scale])
        return out

    def config(self, name, camera=None, lens='as it is', tags=None, family='tag36h11', line_time=0.0,
               mount=LOOKS_DOWN):
        camera = camera or self.camera
        lens = self.lens if lens == 'as it is' else lens
        text = 'camera: {%s' % ', '.join(f'{key}: {value}' for key, value in camera.items())
        if lens:
            text += ', distortion_model: radtan, distortion: %s' % lens
        if line_time:
            text += f', line_time_s: {line_time}'
        text += '}\ncam_from_body: {%s}\ntag_map:\n  family: %s\n  tags:\n' % (mount, family)
        for tag in tags or self.tags_of(self.grid()):
            text += '    - {id: %d, size_m: %.9g, position_m: [%.9g, %.9g, 0], yaw_rad: %.9g}\n' % (
                tag[0], tag[1], tag[2], tag[3], tag[4] if len(tag) > 4 else -math.pi / 2)
        with open(os.path.join(self.folder, name), 'w') as out:
            out.write(text)
        return name

    def run(self, program, *arguments):
        return subprocess.run([os.path.join(self.programs, program), *arguments], cwd=self.folder,
                              capture_output=True, text=True, timeout=300)

    def record(self, map_tags=None):
        config = self.config('true.yaml', line_time=self.line_time, tags=map_tags)
        arguments = ['--output', 'rec', '--config', config, '--trajectory', self.flight, '--height', str(self.height),
                     '--duration', str(self.seconds), '--rate', str(self.rate), '--seed', str(self.seed % 1000 + 1),
                     '--corner_noise_px', str(self.noise)]
        if self.line_time:
            arguments += ['--line_time_s', str(self.line_time)]
        arguments += ['--supersampling', '2', '--scribble', '0'] if self.images else ['--images=false']
        made = self.run('tagtwist_simulate', *arguments)
        if made.returncode:
            raise RuntimeError(made.stderr)

    def path(self, name):
        return os.path.join(self.folder, 'rec', name)

    def detections(self, change):
        """Rows [t, id, four corners] changed one by one."""
        with open(self.path('detections.csv')) as file:
            header, *rows = file.read().splitlines()
        out = [header]
        for row in rows:
            cells = row.split(',')
            corners = [[float(cells[2 + 2 * i]), float(cells[3 + 2 * i])] for i in range(4)]
            t, tag, corners = change(cells[0], cells[1], corners)
            out.append(','.join([t, tag] + [repr(value) for corner in corners for value in corner]))
        with open(self.path('detections.csv'), 'w') as file:
            file.write('\n'.join(out) + '\n')

    def often_seen(self):
        """Ids that at least a third of the frames show."""
        with open(self.path('detections.csv')) as file:
            ids = [int(line.split(',')[1]) for line in file.read().splitlines()[1:]]
        return [tag for tag in sorted(set(ids)) if 3 * ids.count(tag) > self.seconds * self.rate]

    def retell_truth(self, change):
        """The truth as TUM, its rows [t, x, y, z, qx, qy, qz, qw] changed."""
        with open(self.path('ground_truth.csv')) as file:
            rows = [list(map(float, line.split(',')[:8])) for line in file.read().splitlines()[1:]]
        with open(os.path.join(self.folder, 'truth.tum'), 'w') as file:
            for row in rows:
                file.write(' '.join('%.9f' % value for value in change(row)) + '\n')
        self.truth = 'truth.tum'

    def estimate(self):
        arguments = ['--dataset', 'rec', '--config', self.told or 'true.yaml', '--tracks=false', '--output', 'out']
        if not self.images:
            arguments.append('--use_detections')
        if self.truth:
            arguments += ['--ground_truth', self.truth]
        done = self.run('tagtwist_estimate', *arguments, *self.more)
        said = done.stderr + '\n'.join(line for line in done.stdout.splitlines() if line.startswith('finding'))
        return done.returncode, said.strip()


def scaled(camera, keys, factor):
    return {key: value * factor if key in keys else value for key, value in camera.items()}


FOCAL, ALL = ('fx', 'fy'), ('fx', 'fy', 'cx', 'cy')


def focal_length(d):
    d.record()
    d.told = d.config('told.yaml', camera=scaled(d.camera, FOCAL, d.rng.choice([0.5, 0.7, 1.25, 1.5, 2])))


def resolution(d):
    d.record()
    d.told = d.config('told.yaml', camera=scaled(d.camera, ALL, d.rng.choice([0.5, 2, 1.5, 0.75])))


def no_distortion(d):
    d.lens = [d.rng.uniform(-0.32, -0.22), d.rng.uniform(0.06, 0.1), 0.0, 0.0]
    d.record()
    d.told = d.config('told.yaml', lens=None)


def white_border(d):
    d.record()
    tags = d.tags_of(d.grid())
    factor = d.rng.choice([1.25, 0.8])
    d.told = d.config('told.yaml', tags=[[tag[0], tag[1] * factor, tag[2], tag[3]] for tag in tags])


def millimetres(d):
    d.record()
    d.told = d.config('told.yaml', tags=d.tags_of(d.grid(), 1000.0))


def one_tag_moved(d):
    d.record()
    tags = d.tags_of(d.grid())
    moved = tags[d.rng.choice(d.often_seen())]
    angle = d.rng.uniform(0, 2 * math.pi)
    moved[2] += 0.03 * math.cos(angle)
    moved[3] += 0.03 * math.sin(angle)
    d.told = d.config('told.yaml', tags=tags)


def rows_for_columns(d):
    d.record()
    grid = d.grid(rows=d.columns, columns=d.rows, row_gap=d.column_gap, column_gap=d.row_gap)
    d.told = d.config('told.yaml', tags=d.tags_of(grid))


def gaps(d):
    d.record()
    if d.rng.random() < 0.5:  # from centre to centre, for from edge to edge
        grid = d.grid(row_gap=d.row_gap + d.size, column_gap=d.column_gap + d.size)
    else:  # one gap for both directions
        d.column_gap = d.row_gap * d.rng.choice([0.7, 1.4])
        shutil.rmtree(os.path.join(d.folder, 'rec'))
        d.record()
        grid = d.grid(column_gap=d.row_gap)
    d.told = d.config('told.yaml', tags=d.tags_of(grid))


def arucos_order(d):
    d.record()
    d.detections(lambda t, tag, corners: (t, tag, corners[::-1]))


def mirrored(d):
    d.record()
    d.detections(lambda t, tag, corners: (t, tag, [[d.camera['width'] - 1 - u, v] for u, v in corners]))


def shifted_image(d):
    d.record()
    by = d.rng.choice([-1, 1]) * d.rng.uniform(0.08, 0.15)
    camera = dict(d.camera, cx=d.camera['cx'] + by * d.camera['width'], cy=d.camera['cy'] - 0.5 * by * 480)
    d.told = d.config('told.yaml', camera=camera)


def milliseconds(d):
    d.record()
    d.detections(lambda t, tag, corners: ('%.4f' % (1e3 * float(t)), tag, corners))
    for name in ('timestamps.csv', 'imu.csv', 'ground_truth.csv'):
        if os.path.exists(d.path(name)):
            os.remove(d.path(name))


def another_map(d):
    d.record()
    tags = d.tags_of(d.grid())
    ids = [tag[0] for tag in tags]
    d.rng.shuffle(ids)
    d.told = d.config('told.yaml', tags=[[i, *tag[1:]] for i, tag in zip(ids, tags)])


def rolling_shutter(d):
    d.flight = 'agile'
    d.line_time = d.rng.choice([-1, 1]) * d.rng.uniform(3e-5, 6e-5)
    d.record()
    d.told = d.config('told.yaml')


def wrong_family(d):
    d.images, d.seconds, d.rate = True, 1, 10
    d.camera = dict(width=376, height=240, fx=311, fy=311, cx=188, cy=120)
    d.lens = None
    d.record()
    d.told = d.config('told.yaml', family=d.rng.choice(['tag36h10', 'tagStandard41h12', 'tag36h11b2']))


def truths_clock(d):
    d.record()
    by = d.rng.choice([-1, 1]) * d.rng.uniform(0.05, 0.4)
    d.retell_truth(lambda row: [row[0] + by, *row[1:]])


def truth_w_first(d):
    d.record()
    d.retell_truth(lambda row: row[:4] + [row[7]] + row[4:7])


def truth_y_up(d):
    d.record()

    def turn(row):
        t, x, y, z, qx, qy, qz, qw = row
        s = math.sqrt(0.5)  # a quarter turn about x, from the left: (x, y, z) -> (x, z, -y)
        return [t, x, z, -y, s * qx - s * qw, s * qy + s * qz, s * qz - s * qy, s * qw + s * qx]
    d.retell_truth(turn)


def truth_in_mm(d):
    d.record()
    d.retell_truth(lambda row: [row[0], *(1000 * value for value in row[1:4]), *row[4:]])


def mount_inverted(d):
    d.record()
    # Of a camera that looks down the inverse of the turn is the turn; not of one that also stands askew.
    d.told = d.config('told.yaml', mount='rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1], translation_m: [0, 0.04, -0.03]')
    d.retell_truth(lambda row: row)


MISTAKES = {
    focal_length: r'focal length',
    resolution: r'resolution|calibration scaled',
    no_distortion: r'no distortion|lens that bends',
    white_border: r'white border|sizes? of the map|black square',
    millimetres: r'millimetres',
    one_tag_moved: r'tag \d+ (disagrees with the map|was moved)',
    rows_for_columns: r'rows',
    gaps: r'gaps|positions|spacing',
    arucos_order: r'ArUco',
    mirrored: r'mirror',
    shifted_image: r'cropped or shifted|principal point',
    milliseconds: r'milliseconds',
    another_map: r'map is of these tags|map is another|do not lie as the map|order of their ids',
    rolling_shutter: r'rolling shutter',
    wrong_family: r'tag36h11',
    truths_clock: r'clock|time offset|ahead|behind',
    truth_w_first: r'w (is read )?first',
    truth_y_up: r'y is up',
    truth_in_mm: r'millimetres',
    mount_inverted: r'mount',
}


def main():
    programs = os.path.abspath(sys.argv[1])
    draws, right = (int(sys.argv[i]) if len(sys.argv) > i else 1 for i in (2, 3))
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    only = sys.argv[5] if len(sys.argv) > 5 else ''
    named = count = accused = 0
    for mistake, pattern in MISTAKES.items():
        if only and mistake.__name__ not in only.split(','):
            continue
        for i in range(draws):
            with tempfile.TemporaryDirectory() as folder:
                draw = Draw(programs, folder, 1000 * seed + 37 * i + len(mistake.__name__))
                mistake(draw)
                status, said = draw.estimate()
            found = bool(re.search(pattern, said))
            named += found
            count += 1
            print(f'{"named " if found else "MISSED"} {mistake.__name__} {i}: exit {status}: {said[:600]}', flush=True)
    for i in range(right if not only or 'right' in only.split(',') else 0):
        with tempfile.TemporaryDirectory() as folder:
            draw = Draw(programs, folder, 1000 * seed + 500 + i)
            if i % 4 == 3:
                draw.line_time = draw.rng.uniform(2e-5, 5e-5)
            draw.record()
            status, said = draw.estimate()
        accused += bool(said) or status != 0
        print(f'{"ACCUSED" if said else "silent "} right {i}: exit {status}: {said[:600]}', flush=True)
    print(f'{named} of {count} mistakes named; {accused} of {right} right set-ups accused')
    return 0 if 10 * named >= 9 * count and accused == 0 else 1


if __name__ == '__main__':
    sys.exit(main())
