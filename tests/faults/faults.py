"""Disks that fail, memory that ends and processes that are killed, at each moment of a run.

usage: faults.py PROGRAM_DIR LIBRARY [every|SAMPLE] [MODE [KIND]]

LIBRARY (tests/faults) makes the n-th write, rename, fsync, read or malloc of a process fail. After each such run, in
each mode, the results are the older ones or the new ones, whole; exit status 0 says that they are the new ones, and 1
comes with one line on standard error; nothing hidden is left. `every` takes every n (of malloc 2000: the first 1000 and a
spread of the others), a number so many n of each kind, the first ones and a spread of the others. KIND kill: SIGKILL at
as many moments (every: 200), spread at random; kill_rename: at each rename. Then the next run tells what it finds, and
the results are the older ones or the new ones, whole. malloc_rename: after each rename the next malloc fails.
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

KINDS = ('write', 'rename', 'fsync', 'read', 'malloc', 'malloc_rename', 'kill', 'kill_rename')
TIMED = ('summary.json', 'report.html')  # two runs differ in their times
COURSE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'configs', 'course.yaml')


def tree(path):
    """Names below a path, with their contents where these do not tell times; None where nothing is there."""
    if not os.path.lexists(path):
        return None
    if not os.path.isdir(path):
        return open(path, 'rb').read()
    out = {}
    for root, folders, files in os.walk(path):
        for name in folders + files:
            full = os.path.join(root, name)
            out[os.path.relpath(full, path)] = b'' if name in folders or name in TIMED else open(full, 'rb').read()
    return out


class Mode:
    """One way to run: what it writes at `out`, and what lay there before."""

    def __init__(self, name, arguments, older=None, steady=True, by_matio=False):
        self.name, self.arguments, self.older, self.steady, self.by_matio = name, arguments, older, steady, by_matio

    def refused(self):
        """A run over the same results that ends at its input; like every run it begins with what was left."""
        program = self.arguments[0]
        wrong = {'tagtwist_estimate': ['--dataset', 'absent', '--output', 'out'],
                 'tagtwist_simulate': ['--trajectory', 'absent', '--output', 'out'],
                 'tagtwist_map': ['--map', 'absent', '--render', 'out'],
                 'tagtwist_compare': ['absent', '--json', 'out']}
        return [program, *wrong[program]]


def modes():
    estimate = ['tagtwist_estimate', '--dataset', 'rec', '--use_detections', '--threads', '1', '--output', 'out']
    older = ['--max_frames', '8', '--write_covariance']
    yield Mode('batch', estimate, estimate + older)
    yield Mode('window', [*estimate, '--sliding_window', '--write_covariance'], estimate + older)
    # What is dropped depends on the moment.
    yield Mode('live', [*estimate, '--sliding_window', '--realtime', '--stream', 'out/../stream.csv',
                         '--max_frames', '10'], estimate + older,
               steady=False)
    yield Mode('calibrate', [*estimate, '--calibrate'], estimate + older)
    yield Mode('simulate', ['tagtwist_simulate', '--output', 'out', '--images=false', '--duration', '1'])
    yield Mode('simulate_mat', ['tagtwist_simulate', '--output', 'out', '--images=false', '--duration', '1', '--format', 'mat'],
               by_matio=True)
    yield Mode('map', ['tagtwist_map', '--map', COURSE, '--render', 'out'], ['tagtwist_map', '--map', 'map.yaml', '--render', 'out'])
    yield Mode('compare', ['tagtwist_compare', 'o.tum', '--ground_truth', 'o.tum', '--json', 'out'],
               ['tagtwist_compare', 'o.tum', '--ground_truth', 'rec/ground_truth.csv', '--json', 'out'])


class Faults:
    def __init__(self, programs, library, work):
        self.programs, self.preload, self.work = os.path.abspath(programs), os.path.abspath(library), work
        self.out = os.path.join(work, 'out')
        os.mkdir(os.path.join(work, 'tmp'))
        self.run(['tagtwist_simulate', '--output', 'rec', '--images=false', '--duration', '1', '--rate', '30'])
        with open(os.path.join(work, 'o.tum'), 'w') as file:
            file.write(''.join(f'{t / 10} {1 + t} 1 1 0 0 0 1\n' for t in range(5)))
        with open(os.path.join(work, 'map.yaml'), 'w') as file:
            file.write('target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.3\n')

    def start(self, command, **environment):
        return subprocess.Popen([os.path.join(self.programs, command[0]), *command[1:]], cwd=self.work,
                                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                env=dict(os.environ, TMPDIR=os.path.join(self.work, 'tmp'), **environment))

    def run(self, command, **environment):
        process = self.start(command, **environment)
        try:
            _, err = process.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            process.kill()
            return -100, ''
        return process.returncode, err.decode('utf-8', 'replace')

    def clear(self):
        for name in os.listdir(self.work):
            if name not in ('rec', 'o.tum', 'map.yaml', 'tmp', 'older'):
                path = os.path.join(self.work, name)
                shutil.rmtree(path) if os.path.isdir(path) and not os.path.islink(path) else os.remove(path)

    def prepare(self, mode):
        self.clear()
        shutil.rmtree(os.path.join(self.work, 'older'), ignore_errors=True)
        self.older = self.new = None
        if mode.older:
            status, err = self.run(mode.older)
            assert status == 0, (mode.name, err)
            self.older = tree(self.out)
            os.rename(self.out, os.path.join(self.work, 'older'))
        self.clear()
        self.restore()
        status, err = self.run(mode.arguments)
        assert status == 0, (mode.name, err)
        self.new = tree(self.out)
        self.clear()

    def restore(self):
        older = os.path.join(self.work, 'older')
        if os.path.isdir(older):
            shutil.copytree(older, self.out)
        elif os.path.exists(older):
            shutil.copy(older, self.out)

    def same(self, mode, one, other):
        if not mode.steady and isinstance(one, dict) and isinstance(other, dict):
            return set(one) == set(other)
        return one == other

    def left_over(self):
        known = ('rec', 'o.tum', 'map.yaml', 'tmp', 'older', 'out', 'stream.csv')
        return [n for n in os.listdir(self.work) if n not in known] + os.listdir(os.path.join(self.work, 'tmp'))

    def fault_of(self, mode, status, err):
        """What is wrong after a run; '' where nothing is."""
        # A live run says how it went, however it ends.
        err = ''.join(line for line in err.splitlines(True) if ': live: ' not in line)
        now = tree(self.out)
        new, older = self.same(mode, now, self.new), now == self.older
        if status not in (0, 1):
            return f'exit status {status}'
        if status == 0 and not new:
            return 'silent: exit status 0 without the new results'
        if status == 1 and (err.count('\n') != 1 or not err.endswith('\n')):
            return f'{err.count(chr(10))} lines'
        # Where nothing lay before, the summary that says why the run failed may lie there.
        told = self.older is None and isinstance(now, dict) and set(now) <= {'summary.json'}
        if not new and not older and not told:
            return 'neither the older results nor the new ones'
        left = self.left_over()
        return f'left over: {left}' if left else ''

    def count(self, mode, kind):
        self.clear()
        self.restore()
        path = os.path.join(self.work, 'count')
        self.run(mode.arguments, LD_PRELOAD=self.preload, TAGTWIST_FAULT=f'{kind}:0', TAGTWIST_FAULT_COUNT=path)
        return int(open(path).read())

    def numbers(self, total, sample, kind):
        most = 2000 if kind == 'malloc' else total
        wanted = most if sample == 'every' else int(sample)
        if wanted >= total:
            return list(range(1, total + 1))
        first = list(range(1, wanted // 2 + 1))
        return sorted({*first, *(round(first[-1] + (total - len(first)) * (i + 1) / (wanted - len(first)))
                                 for i in range(wanted - len(first)))}) if first else [max(1, total // 2)]

    def fail_each(self, mode, kind, sample):
        counted, after = ('rename', ':malloc') if kind == 'malloc_rename' else (kind, '')
        total, done, told, faults = self.count(mode, counted), 0, 0, []
        for n in self.numbers(total, sample, counted):
            self.clear()
            self.restore()
            status, err = self.run(mode.arguments, LD_PRELOAD=self.preload, TAGTWIST_FAULT=f'{counted}:{n}{after}')
            done, told = done + 1, told + (status == 1)
            # libmatio does not look whether it got memory, and Eigen 3.4 frees twice what it was to resize (SECURITY.md):
            # that is as if it were killed.
            twice = status == -signal.SIGABRT and 'double free' in err
            killed = kind.startswith('malloc') and (
                twice or (mode.by_matio and status in (-signal.SIGSEGV, -signal.SIGABRT)))
            fault = self.fault_of(mode, status, err) if not killed else ''
            # Memory that ends where no exception may leave, as in a library's destructor: its line is told, and what is
            # left is the next run's to remove, as after a kill.
            ended = fault and kind.startswith('malloc') and status == 1 and err.endswith(': out of memory\n')
            if ended and self.set_after_kill(mode) == 'older':
                fault = ''
            if killed and (which := self.set_after_kill(mode)) != 'older':
                fault = f'exit status {status}, then {which}'
            if fault:
                faults.append(n)
                print(f'{mode.name}, {kind} {n} of {total}: {fault}: {err[:300]!r}', flush=True)
        print(f'{mode.name}: {kind}: {done} of {total} failed, {told} told, {len(faults)} wrong', flush=True)
        return len(faults)

    def set_after_kill(self, mode):
        """'older' or 'new': what the next run leaves, which ends at its input; else what is wrong."""
        status, err = self.run(mode.refused())
        now = tree(self.out)
        if status != 1:
            return f'the next run: exit status {status}: {err!r}'
        if self.left_over():
            return f'left over: {self.left_over()}: {err!r}'
        if now == self.older:
            return 'older'
        kept = sorted(now) if isinstance(now, dict) else now if now is None else len(now)
        return 'new' if self.same(mode, now, self.new) else f'neither set: {kept}: {err!r}'

    def tell_kills(self, mode, kind, sets):
        olds, news = sets.count('older'), sets.count('new')
        wrong = [which for which in sets if which not in ('older', 'new')]
        for which in wrong:
            print(f'{mode.name}, {kind}: {which}', flush=True)
        print(f'{mode.name}: {kind}: {len(sets)} killed: {olds} older results, {news} new ones, {len(wrong)} wrong',
              flush=True)
        return len(wrong)

    def kill_at_random(self, mode, count):
        start = time.monotonic()
        self.clear()
        self.restore()
        self.run(mode.arguments)
        whole_s, rng, sets = time.monotonic() - start, random.Random(7), []
        for _ in range(count):
            self.clear()
            self.restore()
            process = self.start(mode.arguments)
            time.sleep(rng.uniform(0, 1.1 * whole_s))
            process.send_signal(signal.SIGKILL)
            process.communicate()
            sets.append(self.set_after_kill(mode))
        return self.tell_kills(mode, 'kill', sets)

    def kill_at_renames(self, mode, sample):
        sets = []
        for n in self.numbers(self.count(mode, 'rename'), sample, 'rename'):
            self.clear()
            self.restore()
            status, _ = self.run(mode.arguments, LD_PRELOAD=self.preload, TAGTWIST_FAULT=f'rename:{n}:kill')
            which = self.set_after_kill(mode)
            sets.append(which if status == -signal.SIGKILL else f'rename {n}: exit status {status}, not killed')
        return self.tell_kills(mode, 'kill_rename', sets)


def main():
    programs, library = sys.argv[1:3]
    sample = sys.argv[3] if len(sys.argv) > 3 else '4'
    wanted_mode, wanted_kind = (sys.argv[4:6] + ['', ''])[:2]
    work = tempfile.mkdtemp(prefix='tagtwist_faults_')
    wrong = 0
    try:
        faults = Faults(programs, library, work)
        for mode in modes():
            if wanted_mode not in ('', 'all', mode.name):
                continue
            faults.prepare(mode)
            for kind in KINDS:
                if wanted_kind not in ('', kind):
                    continue
                if kind == 'kill':
                    wrong += faults.kill_at_random(mode, 200 if sample == 'every' else int(sample))
                elif kind == 'kill_rename':
                    wrong += faults.kill_at_renames(mode, sample)
                else:
                    wrong += faults.fail_each(mode, kind, sample)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
