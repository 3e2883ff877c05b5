"""A rendered flight played as if live, with what it tells on its way: python3 live_run.py PROGRAMS is no test."""
import os
import queue
import re
import socket
import subprocess
import tempfile
import threading


class ProgramRun:
    """A program in a folder of its own, with what it tells on its way."""

    def __init__(self, folder, command):
        self.folder = folder
        self.process = subprocess.Popen(command, cwd=folder.name, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.lines, self.told = queue.Queue(), []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.told.append(line)
            self.lines.put(line)

    def link(self, name='page'):
        """The address of a line "page       http://..."."""
        while True:
            found = re.match(name + r' +(\S+)$', self.lines.get(timeout=60))
            if found:
                return found.group(1)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def finish(self):
        """Exit status and what was told on standard error."""
        error = self.process.stderr.read()
        status = self.process.wait(timeout=100)
        self.reader.join()
        return status, error

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.folder.cleanup()


class LiveRun(ProgramRun):
    """tagtwist_estimate --realtime over a flight in a folder of its own."""

    def __init__(self, programs, more, rate=30, seconds=8, simulate=()):
        folder = tempfile.TemporaryDirectory(prefix='tagtwist-live-')
        programs = os.path.abspath(programs)
        subprocess.run([os.path.join(programs, 'tagtwist_simulate'), '--output', 'flight', '--trajectory', 'hover',
                        '--rate', str(rate), '--duration', str(seconds), '--imu_rate', '0', *simulate],
                       cwd=folder.name, check=True, stdout=subprocess.DEVNULL)
        super().__init__(folder, [os.path.join(programs, 'tagtwist_estimate'), '--dataset', 'flight', '--sliding_window', '--realtime',
                                  '--output', 'out', *more])


def said(port, request, patience_s=5):
    """What a server at that port of this machine answers to bytes."""
    with socket.create_connection(('127.0.0.1', port), timeout=patience_s) as connection:
        connection.sendall(request)
        out = b''
        try:
            while True:
                got = connection.recv(1 << 16)
                if not got:
                    return out
                out += got
                if b'101 Switching' in out:
                    return out
        except (TimeoutError, ConnectionError):
            return out


def request(port, method='GET', target='/', host=None, more=''):
    host = f'127.0.0.1:{port}' if host is None else host
    return f'{method} {target} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n'.encode()


def upgrade(protocol, more=''):
    return (f'Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
            f'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {protocol}\r\n{more}')
