"""What others send to the page's port: refused cleanly, whatever it is; clients that do not read, or go, cost nothing.

python3 guard_test.py PROGRAMS"""
import json
import os
import random
import socket
import sys
import time

import live_run
from live_run import request, said, upgrade

PAGE = 'tagtwist.live.v1'


def status_of(answer):
    return answer.split(b' ', 2)[1].decode() if answer.startswith(b'HTTP/1.1 ') else answer[:40].decode('latin-1')


def check_requests(port):
    """Requests to a page without a token, with what they are to get."""
    head = answer = None
    for wanted, what in [
            ('200', request(port)), ('200', request(port, 'HEAD')), ('200', request(port, host=f'localhost:{port}')),
            ('200', request(port, more=f'Origin: http://127.0.0.1:{port}\r\n')),
            ('403', request(port, host='evil.example')), ('403', request(port, host=f'evil.example:{port}')),
            ('403', request(port, host='')), ('403', b'GET / HTTP/1.0\r\n\r\n'),
            ('403', request(port, more=f'Host: localhost:{port}\r\n')),  # two
            ('403', request(port, more='Origin: http://evil.example\r\n')), ('403', request(port, more='Origin: null\r\n')),
            ('403', request(port, more=upgrade(PAGE, 'Origin: http://evil.example\r\n'))),
            ('403', request(port, more=upgrade('foxglove.websocket.v1', 'Origin: https://app.foxglove.dev\r\n'))),
            ('403', request(port, host='evil.example', more=upgrade(PAGE))),
            ('404', request(port, target='/etc/passwd')), ('404', request(port, target='/../../etc/passwd')),
            ('404', request(port, target='/%2e%2e/etc/passwd')), ('404', request(port, target='//')),
            ('404', request(port, target='http://evil.example/')), ('404', request(port, target='*')),
            ('404', request(port, target='/index.html')), ('405', request(port, 'POST')), ('405', request(port, 'PUT')),
            ('405', request(port, 'DELETE', '/results')), ('405', request(port, 'OPTIONS')), ('405', request(port, 'TRACE')),
            ('413', request(port, 'POST', more='Content-Length: 99999999999\r\n')),
            ('431', request(port, more='X: ' + 'x' * 20000 + '\r\n')),
            ('400', request(port, more=upgrade('chat'))), ('400', request(port, target='/live', more=upgrade(PAGE))),
            ('400', b'\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03' + bytes(50)), ('400', b'GET\r\n\r\n'),
            ('400', b'GET / HTTP/9.9\r\n\r\n'), ('400', request(port, more='no colon\r\n')),
            ('101', request(port, more=upgrade(PAGE))), ('101', request(port, more=upgrade('foxglove.websocket.v1'))),
            ('101', request(port, more=upgrade('chat, ' + PAGE)))]:
        answer = said(port, what)
        assert status_of(answer) == wanted, (wanted, what[:200], answer[:300])
        if what == request(port):
            head = answer.split(b'\r\n\r\n')[0].decode()
    for line in ("Content-Security-Policy: default-src 'none'", 'X-Content-Type-Options: nosniff', 'Referrer-Policy: no-referrer'):
        assert line in head, head
    assert 'Access-Control' not in head
    return answer


def check_noise(port, n):
    """Requests with bytes changed, and bytes of no meaning, before and after an upgrade: the server answers on."""
    draw = random.Random(7)
    plain = [request(port), request(port, more=upgrade(PAGE)), request(port, more=upgrade('foxglove.websocket.v1'))]
    for _ in range(n):
        bytes_ = bytearray(draw.choice(plain))
        for _ in range(draw.randrange(1, 8)):
            bytes_[draw.randrange(len(bytes_))] = draw.randrange(256)
        with socket.create_connection(('127.0.0.1', port), timeout=5) as connection:
            connection.sendall(bytes(bytes_))
    for _ in range(n // 10):
        with socket.create_connection(('127.0.0.1', port), timeout=5) as connection:
            connection.sendall(draw.choice(plain[1:]))
            connection.recv(200)
            try:
                for _ in range(5):
                    connection.sendall(draw.randbytes(draw.randrange(1, 3000)))
            except ConnectionError:
                pass  # it has had enough
    assert status_of(said(port, plain[0])) == '200'


def stalled(port, protocol, subscribe=False):
    """A client that says hello and then reads no more."""
    connection = socket.create_connection(('127.0.0.1', port), timeout=5)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.sendall(request(port, more=upgrade(protocol)))
    assert b'101' in connection.recv(100)
    if subscribe:
        wish = json.dumps({'op': 'subscribe', 'subscriptions': [{'id': i, 'channelId': i} for i in range(1, 7)]}).encode()
        mask = bytes(4)
        connection.sendall(b'\x81' + bytes([0x80 | 126]) + len(wish).to_bytes(2, 'big') + mask + wish)
    return connection


def check_crowd(port):
    """Many at once: those beyond the bound are let go, the others served; afterwards there is room again."""
    crowd = [socket.create_connection(('127.0.0.1', port), timeout=5) for _ in range(100)]
    time.sleep(0.3)
    for connection in crowd:
        connection.close()
    time.sleep(0.3)
    assert status_of(said(port, request(port))) == '200'


def main():
    flags = ['--page', '0', '--publish', 'foxglove', '--publish', 'udp://127.0.0.1:9']
    with live_run.LiveRun(sys.argv[1], flags, rate=30, seconds=10) as run:
        port = int(run.link('page').split(':')[2].rstrip('/'))
        still = [stalled(port, PAGE), stalled(port, 'foxglove.websocket.v1', True)]
        check_requests(port)
        check_noise(port, 200)
        check_crowd(port)
        for _ in range(5):
            stalled(port, PAGE).close()  # one that vanishes
        status, error = run.finish()
        assert status == 0, error
        for connection in still:
            connection.close()
        with open(run.path('out/summary.json'), encoding='utf-8') as file:
            summary = json.load(file)
        frames, dropped = summary['frames'], summary['live']['frames_dropped']
        print(f'{frames} frames, {dropped} dropped, latency {summary["live"]["latency_ms"]}')
        assert frames + dropped == 301
    with live_run.LiveRun(sys.argv[1], ['--page', '0', '--listen', '127.0.0.1', '--max_frames', '40'], rate=20, seconds=3) as run:
        link = run.link('page')
        port, token = int(link.split(':')[2].split('/')[0]), link.split('token=')[1]
        assert len(token) == 32
        for wanted, target in [('403', '/'), ('403', '/?token='), ('403', '/?token=' + token[:-1]), ('403', '/?token=' + '0' * 32),
                               ('200', '/?token=' + token), ('404', '/x?token=' + token)]:
            assert status_of(said(port, request(port, target=target))) == wanted, target
        assert status_of(said(port, request(port, more=upgrade(PAGE)))) == '403'
        assert status_of(said(port, request(port, target='/?token=' + token, host='robot.local', more=upgrade(PAGE)))) == '101'
        run.finish()
    taken = socket.create_server(('127.0.0.1', 0))
    with live_run.LiveRun(sys.argv[1], ['--page', str(taken.getsockname()[1])], rate=10, seconds=1) as run:
        status, error = run.finish()
        assert status == 1 and error.count('\n') == 1 and 'Address already in use' in error, error
        assert not os.path.exists(run.path('out/states.csv'))
    return 0


if __name__ == '__main__':
    sys.exit(main())
