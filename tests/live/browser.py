"""A page in headless Chromium, driven over its debugging pipe: no package is needed for it."""
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time


class Browser:
    """Opens no page by itself; faults that pages report are in `faults`."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_read, self.to = os.pipe()
        self.back, to_write = os.pipe()

        def ends():  # Chromium reads what it is told from descriptor 3, and answers on 4
            first, second = os.dup(to_read), os.dup(to_write)
            os.dup2(first, 3)
            os.dup2(second, 4)

        self.process = subprocess.Popen(
            ['chromium', '--headless=new', '--no-sandbox', '--disable-gpu', '--remote-debugging-pipe',
             '--no-first-run', '--user-data-dir=' + self.folder.name],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=ends, close_fds=False,
            env={**os.environ, 'HOME': self.folder.name})
        os.close(to_read)
        os.close(to_write)
        self.rest, self.next_id, self.faults = b'', 1, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.to)
        os.close(self.back)
        self.folder.cleanup()

    def call(self, method, session=None, timeout_s=60, **params):
        number, self.next_id = self.next_id, self.next_id + 1
        message = {'id': number, 'method': method, 'params': params}
        if session:
            message['sessionId'] = session
        os.write(self.to, json.dumps(message).encode() + b'\0')
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            answer = self._next(end)
            if answer and answer.get('id') == number:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]}')
                return answer['result']
        raise TimeoutError(method)

    def _next(self, end):
        while b'\0' not in self.rest:
            ready, _, _ = select.select([self.back], [], [], max(0, end - time.monotonic()))
            if not ready:
                return None
            got = os.read(self.back, 1 << 20)
            if not got:
                raise RuntimeError('the browser is gone')
            self.rest += got
        text, self.rest = self.rest.split(b'\0', 1)
        message = json.loads(text)
        self._note(message)
        return message

    def _note(self, message):
        method, params = message.get('method'), message.get('params', {})
        if method == 'Runtime.exceptionThrown':
            self.faults.append(json.dumps(params['exceptionDetails'])[:500])
        if method == 'Runtime.consoleAPICalled' and params['type'] in ('error', 'warning'):
            self.faults.append(json.dumps(params['args'])[:500])
        if method == 'Log.entryAdded' and params['entry']['level'] in ('error', 'warning'):
            self.faults.append(json.dumps(params['entry'])[:500])

    def open(self, url, width=1280, height=900, dark=False, phone=False):
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        page = Page(self, session)
        for domain in ('Runtime', 'Log', 'Page'):
            page.call(domain + '.enable')
        page.call('Emulation.setDeviceMetricsOverride', width=width, height=height,
                  deviceScaleFactor=2 if phone else 1, mobile=phone)
        page.call('Emulation.setEmulatedMedia',
                  features=[{'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}])
        page.call('Page.navigate', url=url)
        page.wait('document.readyState === "complete" && location.protocol === "http:"')
        return page


class Page:
    def __init__(self, browser, session):
        self.browser, self.session = browser, session

    def call(self, method, **params):
        return self.browser.call(method, session=self.session, **params)

    def run(self, script):
        """The value of a JavaScript expression."""
        out = self.call('Runtime.evaluate', expression=script, returnByValue=True, awaitPromise=True)
        if 'exceptionDetails' in out:
            raise RuntimeError(json.dumps(out['exceptionDetails'])[:500])
        return out['result'].get('value')

    def wait(self, script, timeout_s=120):
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            if self.run(script):
                return
            time.sleep(0.1)
        raise TimeoutError(script)

    def screenshot(self, path):
        data = self.call('Page.captureScreenshot', captureBeyondViewport=True)['data']
        with open(path, 'wb') as file:
            file.write(base64.b64decode(data))


def is_there():
    return shutil.which('chromium') is not None
