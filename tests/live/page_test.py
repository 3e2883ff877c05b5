"""The live page in a real browser: axes where the tags are, nothing on the console, no sideways scrolling.

python3 page_test.py PROGRAMS [SCREENSHOTS]; exit status 77 where there is no Chromium."""
import csv
import json
import math
import sys
import tempfile
import time

import browser
import live_run

# The course's camera, mount and mat, by hand: nothing of the program's is used here.
FX, FY, CX, CY = 311.0520, 311.3885, 201.8724, 113.6210
SIZE = 0.152


def tag_centre(tag):
    column, row = divmod(tag, 12)
    return (0.304 * row + SIZE / 2, 0.304 * column + 0.026 * (column >= 3) + 0.026 * (column >= 6) + SIZE / 2, 0.0)


def rotated(q, v):
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def pixel(pose, point):
    """Where the course's camera sees a point of the world from a body's pose (x y z qx qy qz qw)."""
    inverse = (-pose[3], -pose[4], -pose[5], pose[6])
    b = rotated(inverse, [point[k] - pose[k] for k in range(3)])
    c = math.sqrt(0.5)
    in_cam = (c * b[0] - c * b[1] - 0.04, -c * b[0] - c * b[1], -b[2] - 0.03)
    return FX * in_cam[0] / in_cam[2] + CX, FY * in_cam[1] / in_cam[2] + CY


def truth_at(path, t):
    with open(path, encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    row = min(rows, key=lambda r: abs(float(r['t']) - t))
    assert abs(float(row['t']) - t) < 1e-6, (row['t'], t)
    return [float(row[k]) for k in ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')]


SAMPLE = '''(() => {
  const canvas = document.getElementById("view"), g = canvas.getContext("2d"), scale = Number(canvas.dataset.scale);
  return POINTS.map(([u, v]) => Array.from(g.getImageData(Math.round(scale * (u + 0.5) - 0.5), Math.round(scale * (v + 0.5) - 0.5), 1, 1).data.slice(0, 3)));
})()'''


def check_axes(page, run):
    """A third along the tags' x and y axes the page is red and green; beside them it is not."""
    page.run('document.getElementById("pause").click()')
    time.sleep(0.3)
    t = float(page.run('document.getElementById("view").dataset.t'))
    pose = truth_at(run.path('flight/ground_truth.csv'), t)
    axes, beside = {'red': [], 'green': []}, []
    for tag in range(108):
        x, y, z = tag_centre(tag)
        corners = [pixel(pose, (x + dx * SIZE / 2, y + dy * SIZE / 2, z)) for dx in (-1, 1) for dy in (-1, 1)]
        if not all(5 < u < 370 and 5 < v < 234 for u, v in corners):
            continue
        third = 0.34 * SIZE / 2
        axes['red'].append(pixel(pose, (x, y + third, z)))     # x: to the right as printed, y of the world
        axes['green'].append(pixel(pose, (x - third, y, z)))   # y: up as printed
        beside.append(pixel(pose, (x + third, y - third, z)))
    assert len(beside) >= 4, beside

    def sample(points):
        return page.run(SAMPLE.replace('POINTS', json.dumps(points)))

    red = [r > 180 and g < 140 and b < 140 for r, g, b in sample(axes['red'])]
    green = [g > 160 and r < 140 and b < 170 for r, g, b in sample(axes['green'])]
    grey = [max(c) - min(c) < 40 for c in sample(beside)]
    print(f'axes at t = {t}: x {sum(red)}, y {sum(green)}, neither beside {sum(grey)}, of {len(beside)} tags')
    assert all(red) and all(green) and all(grey), (red, green, grey)
    page.run('document.getElementById("pause").click()')


FOUND = '''(() => {
  const cells = [...document.querySelectorAll("#numbers td")].map((c) => c.textContent);
  return {
    verdict: document.getElementById("verdict").textContent,
    status: document.getElementById("status").textContent,
    wider: document.documentElement.scrollWidth > innerWidth,
    numbers: cells.length, missing: cells.filter((c) => !/[0-9]/.test(c)).length,
    plots: [...document.querySelectorAll("canvas")].filter((c) => c.width > 0 && c.getContext("2d").getImageData(0, 0, c.width, c.height).data.some((v) => v)).length,
    unnamed: [...document.querySelectorAll("button, canvas, section")].filter((e) => !(e.hidden || e.getAttribute("aria-label") || e.getAttribute("aria-labelledby") || e.textContent.trim())).length,
    described: document.getElementById("path").getAttribute("aria-label"),
  };
})()'''


def check_page(page):
    page.wait('document.getElementById("status").textContent === "ok"')
    page.wait('document.getElementById("view").dataset.t')
    page.wait('document.getElementById("rate").textContent.includes("Hz")')
    time.sleep(0.5)
    found = page.run(FOUND)
    print(found)
    assert found['plots'] == 6 and found['missing'] == 0 and found['numbers'] == 24, found
    assert not found['wider'] and found['unnamed'] == 0, found
    assert 'metres' in found['described'], found


def check_keys(page):
    press = 'document.getElementById("path").dispatchEvent(new KeyboardEvent("keydown", {key: "KEY", cancelable: true, bubbles: true}))'
    assert page.run(press.replace('KEY', 'ArrowLeft')) is False  # it was taken
    assert page.run(press.replace('KEY', 'x')) is True
    page.run(press.replace('KEY', 'p'))
    assert page.run('document.getElementById("pause").getAttribute("aria-pressed")') == 'true'
    page.run(press.replace('KEY', 'p'))


def check_record(page, run):
    page.wait('document.getElementById("recording").textContent.includes("images in rec")')
    page.run('document.getElementById("record").click()')
    page.wait('document.getElementById("record").getAttribute("aria-pressed") === "false"')
    page.run('document.getElementById("record").click()')
    page.wait('document.getElementById("record").getAttribute("aria-pressed") === "true"')
    with open(run.path('rec/timestamps.csv'), encoding='utf-8') as file:
        assert len(file.readlines()) > 5


def check_bodies(programs):
    """The mat's last four columns as a body of their own: chosen, the numbers are its."""
    grid = 'grid: {rows: 12, columns: %d, first_id: %d, tag_size_m: 0.152, row_gaps_m: 0.152, column_gaps_m: %s}\n'
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as config:
        config.write('tag_map:\n  ' + grid % (5, 0, [0.152, 0.152, 0.178, 0.152]) +
                     '  bodies:\n    - name: rest\n      ' + grid % (4, 60, [0.178, 0.152, 0.152]))
        config.flush()
        with browser.Browser() as chromium, \
                live_run.LiveRun(programs, ['--page', '0', '--config', config.name], rate=10, seconds=8) as run:
            page = chromium.open(run.link('page'), 1280, 900)
            page.wait('document.getElementById("status").textContent === "ok"')
            assert page.run('[...document.getElementById("body").options].map((o) => o.textContent)') == ['body', 'rest']
            assert page.run('document.getElementById("camera").hidden') is True
            page.run('document.dispatchEvent(new KeyboardEvent("keydown", {key: "b", bubbles: true}))')
            page.wait('Math.abs(Number(document.querySelectorAll("#numbers td")[1].textContent) - 1.546) < 0.05')
            page.wait('document.getElementById("verdict").textContent.includes("rest: ")')
            assert not chromium.faults, chromium.faults


def main():
    if not browser.is_there():
        print('chromium is not installed')
        return 77
    check_bodies(sys.argv[1])
    seconds = 20 if len(sys.argv) > 2 else 12
    with live_run.LiveRun(sys.argv[1], ['--page', '0', '--record', 'rec'], rate=20, seconds=seconds) as run, \
            browser.Browser() as chromium:
        link = run.link('page')
        for name, size, dark, phone in (('desktop-light', (1280, 900), False, False), ('phone-dark', (390, 844), True, True),
                                        ('desktop-dark', (1280, 900), True, False), ('phone-light', (390, 844), False, True)):
            if len(sys.argv) <= 2 and name in ('desktop-dark', 'phone-light'):
                continue
            page = chromium.open(link, *size, dark=dark, phone=phone)
            check_page(page)
            check_axes(page, run)
            if name == 'desktop-light':
                check_keys(page)
                check_record(page, run)
            if len(sys.argv) > 2:
                page.screenshot(f'{sys.argv[2]}/{name}.png')
        status, error = run.finish()
        assert status == 0, error
        page.wait('document.getElementById("verdict").textContent.length > 0')
        own = ('ERR_CONNECTION_REFUSED', 'willReadFrequently')  # after the end, and of this test's look at pixels
        faults = [fault for fault in chromium.faults if not any(word in fault for word in own)]
        assert not faults, faults
    return 0


if __name__ == '__main__':
    sys.exit(main())
