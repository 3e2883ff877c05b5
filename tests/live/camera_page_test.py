"""The page of tagtwist_camera in a real browser: the image with the corners found, what to show next, where the image was
covered, sigmas and verdict; nothing on the console; refused without the token.

python3 camera_page_test.py PROGRAMS [SCREENSHOTS]; exit status 77 where there is no Chromium."""
import math
import os
import re
import subprocess
import sys
import tempfile

import browser
import live_run

SHEET = ('tag_map:\n  family: tag36h11\n'
         '  grid: {rows: 6, columns: 6, tag_size_m: 0.03, row_gaps_m: 0.01, column_gaps_m: 0.01}\n')
CAMERA = ('camera: {width: 320, height: 240, fx: 231.7, fy: 230.9, cx: 162.3, cy: 117.8, distortion: [-0.21, 0.05, 0.0004, -0.0006]}\n'
          'cam_from_body: {rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation_m: [0, 0, 0]}\n')


def product(a, b):
    (x, y, z, w), (i, j, k, r) = a, b
    return (w * i + x * r + y * k - z * j, w * j - x * k + y * r + z * i, w * k + x * j - y * i + z * r, w * r - x * i - y * j - z * k)


def about(axis, angle):
    return tuple(math.sin(angle / 2) * c for c in axis) + (math.cos(angle / 2),)


def way(seconds):
    """A camera that circles over the sheet and looks at it, hardly tilted at first, then from up to 46 degrees aside."""
    out = 't,x,y,z,qx,qy,qz,qw\n'
    for i in range(int(50 * seconds) + 2):
        t = 0.02 * i
        turn = 2 * math.pi * t / 3
        tilt, azimuth = min(0.8, max(0.04, 0.1 * (t - 8))) * math.sin(turn / 2.3), turn / 7.1
        side = (math.sin(tilt) * math.cos(azimuth), math.sin(tilt) * math.sin(azimuth), math.cos(tilt))
        target = (0.115 + 0.07 * math.sin(turn / 1.7), 0.115 + 0.07 * math.sin(turn / 3.7), 0)
        distance = 0.2 + 0.05 * math.sin(turn / 4.1)
        # The z axis turned to `side` about what is across both, then the camera looks down.
        leaning = about((-math.sin(azimuth), math.cos(azimuth), 0), tilt)
        q = product(product(leaning, (0, 1, 0, 0)), about((0, 0, 1), 0.8 * math.sin(turn / 5.3)))
        place = [target[k] + distance * side[k] for k in range(3)]
        out += ','.join(f'{v:.9f}' for v in (t, *place, *q)) + '\n'
    return out


class Calibration(live_run.ProgramRun):
    """tagtwist_camera with a page over a film in a folder of its own."""

    def __init__(self, programs, seconds, more=()):
        folder, programs = tempfile.TemporaryDirectory(prefix='tagtwist-camera-'), os.path.abspath(programs)
        for name, text in (('sheet.yaml', SHEET), ('truth.yaml', CAMERA + SHEET), ('way.csv', way(seconds))):
            with open(os.path.join(folder.name, name), 'w', encoding='utf-8') as file:
                file.write(text)
        subprocess.run([os.path.join(programs, 'tagtwist_simulate'), '--output', 'film', '--config', 'truth.yaml', '--trajectory',
                        'way.csv', '--imu_rate', '0', '--rate', '10', '--duration', str(seconds), '--scribble', '0'],
                       cwd=folder.name, check=True, stdout=subprocess.DEVNULL)
        super().__init__(folder, [os.path.join(programs, 'tagtwist_camera'), '--from', 'film', '--map', 'sheet.yaml', '--output', 'camera.yaml',
                                  '--report', 'camera.html', '--page', '0', *more])


FOUND = '''(() => ({
  status: document.getElementById("status").textContent, words: document.getElementById("words").textContent,
  next: [...document.querySelectorAll("#next li")].map((line) => line.textContent),
  kept: Number(document.getElementById("kept").textContent), share: document.getElementById("covered-share").textContent,
  rows: [...document.querySelectorAll("#rows tr")].map((row) => [...row.children].map((c) => c.textContent)),
  wider: document.documentElement.scrollWidth > innerWidth,
  unnamed: [...document.querySelectorAll("button, canvas, section")].filter((e) => !(e.getAttribute("aria-label") || e.getAttribute("aria-labelledby") || e.textContent.trim())).length,
  covered: document.getElementById("cover").getAttribute("aria-label"), view: document.getElementById("view").getAttribute("aria-label"),
}))()'''

GREEN = '''(() => {
  const canvas = document.getElementById("view"), pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let n = 0;
  for (let i = 0; i < pixels.length; i += 4) if (pixels[i] === 0x3b && pixels[i + 1] === 0xd6 && pixels[i + 2] === 0x5a) n++;
  return n;
})()'''


def check_page(page):
    page.wait('document.getElementById("view").dataset.t')
    page.wait('Number(document.getElementById("kept").textContent) > 0')
    page.wait('document.getElementById("view").getAttribute("aria-label").match(/with [1-9]/)')
    found = page.run(FOUND)
    print(found)
    assert not found['wider'] and found['unnamed'] == 0, found
    assert found['status'] in ('looking', 'calibrating'), found
    assert page.run(GREEN) > 100  # corners are marked
    assert '%' in found['covered'] and '%' in found['share'], found


def check_keys(page):
    press = 'document.dispatchEvent(new KeyboardEvent("keydown", {key: "KEY", bubbles: true}))'
    for key, button in (('p', 'pause'), ('c', 'covered-toggle')):
        before = page.run(f'document.getElementById("{button}").getAttribute("aria-pressed")')
        page.run(press.replace('KEY', key))
        assert page.run(f'document.getElementById("{button}").getAttribute("aria-pressed")') != before
        page.run(press.replace('KEY', key))


# What the page says when it first has rows: asked from here, a busy machine's may have gone on to the end. A machine so
# busy that few images are measured may have all that is wanted by then.
WATCH_ROWS = '''(() => {
  const look = () => {
    const rows = document.querySelectorAll("#rows tr").length
    if (rows > 3 && window.atFirstRows === undefined) {
      window.atFirstRows = {status: document.getElementById("status").textContent, next: document.querySelectorAll("#next li").length}
    }
  }
  new MutationObserver(look).observe(document.body, {childList: true, subtree: true, characterData: true})
  look()
})()'''


def check_end(page, run, was_good):
    page.wait('document.getElementById("status").textContent === "good"', timeout_s=300)
    found = page.run(FOUND)
    print(found)
    # Of the distortion another model has other numbers, each of which may be less sure.
    sigmas = {row[0]: (float(row[2]), float(row[3])) for row in found['rows'] if row[0].endswith('[px]')}
    assert all(now <= first for now, first in sigmas.values()), sigmas
    assert was_good or sigmas['fx [px]'][0] < 0.7 * sigmas['fx [px]'][1], sigmas
    numbers = {row[0].split(' ')[0]: (float(row[1]), float(row[2])) for row in found['rows']}
    for name, true in (('fx', 231.7), ('fy', 230.9), ('cx', 162.3), ('cy', 117.8)):
        value, sigma = numbers[name]
        assert abs(value - true) < 5 * sigma and sigma < 2, (name, value, sigma)
    assert found['next'] == [] and 'nothing speaks against it' in found['words'], found
    assert run.process.wait(timeout=300) == 0, run.process.stderr.read()
    with open(run.path('camera.html'), encoding='utf-8') as file:
        report = file.read()
    assert 'nothing speaks against it' in report and '<svg' in report and 'fx [px]' in report


def check_refused(programs):
    """From elsewhere only with the token."""
    with Calibration(programs, 3, ['--listen', '0.0.0.0']) as run:
        link = run.link()
        found = re.match(r'http://[^:/]+:(\d+)/\?token=([0-9a-f]{32})$', link)
        assert found, link
        port, token = int(found.group(1)), found.group(2)
        for target, wanted in (('/', b'403'), ('/?token=' + '0' * 32, b'403'), ('/?token=' + token, b'200'), ('/camera.yaml?token=' + token, b'404')):
            answer = live_run.said(port, live_run.request(port, target=target))
            assert answer.split(b' ')[1] == wanted, (target, answer[:200])


def main():
    if not browser.is_there():
        print('chromium is not installed')
        return 77
    check_refused(sys.argv[1])
    shots = sys.argv[2] if len(sys.argv) > 2 else None
    with browser.Browser() as chromium, Calibration(sys.argv[1], 40) as run:
        link = run.link()
        for name, size, dark, phone in (('camera-desktop-light', (1280, 900), False, False), ('camera-phone-dark', (390, 844), True, True)):
            page = chromium.open(link, *size, dark=dark, phone=phone)  # only the page in front is drawn
            page.run(WATCH_ROWS)
            check_page(page)
            if not phone:
                check_keys(page)
                page.wait('window.atFirstRows !== undefined', timeout_s=300)
                first = page.run('window.atFirstRows')
                assert (first['status'] == 'good') == (first['next'] == 0), first  # else it says what is missing
            if shots:
                page.screenshot(f'{shots}/{name}.png')
        check_end(page, run, first['status'] == 'good')
        if shots:
            page.screenshot(f'{shots}/camera-end.png')
        own = ('ERR_CONNECTION_REFUSED', 'willReadFrequently')
        faults = [fault for fault in chromium.faults if not any(word in fault for word in own)]
        assert not faults, faults
    return 0


if __name__ == '__main__':
    sys.exit(main())
