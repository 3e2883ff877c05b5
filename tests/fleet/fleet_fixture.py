"""24 recordings with faults among them, and the program over them. Programs: TAGTWIST_PROGRAM_DIR."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

PROGRAMS = pathlib.Path(os.environ["TAGTWIST_PROGRAM_DIR"])
HOSTILE = "a 'b' \"c\" <script>alert(1)</script> & $(touch pwned); d"
# What each faulty recording's row must say.
FAULTS = {"no tags": "no frame shows a tag of the map", "damaged": "damaged", "wrong map": "map"}
# Files that hold no time of day.
BYTES = ("states.csv", "optimised.tum", "closed_form.tum", "ground_truth.tum")
SKIP = 77


def missing():
    return "" if shutil.which("snakemake") else "snakemake is not installed (scripts/setup fleet)"


def call(program, *arguments):
    done = subprocess.run([str(PROGRAMS / program), *map(str, arguments)], capture_output=True, text=True, check=False,
                          stdin=subprocess.DEVNULL)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return done


def simulate(folder, seed, *more, images=False):
    call("tagtwist_simulate", "--output", folder, "--seed", seed, "--imu_rate", "0", "--threads", "1",
         *more, *([] if images else ["--noimages", "--corner_noise_px", "0.1"]))


def make_recordings(folder, count=24, duration_s=2):
    """Corners and rendered ones below `folder`, and list.csv."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True)
    short = ("--duration", "1", "--rate", "10")
    simulate(folder / "rendered", 1, *short, images=True)
    simulate(folder / "no tags", 2, *short, "--hide_tags_from", "-1", "--hide_tags_to", "9", images=True)
    call("tagtwist_estimate", "--dataset", folder / "rendered", "--output", folder / "scratch", "--overlay",
         folder / "damaged.avi")
    shutil.rmtree(folder / "scratch")
    video = (folder / "damaged.avi").read_bytes()
    (folder / "damaged.avi").write_bytes(video[:len(video) // 2])
    rows = [("rendered", "", "false", ""), ("no tags", "", "false", ""), ("damaged.avi", "damaged", "false", ""),
            ("wrong map", "", "true", "wrong.yaml"), ("no truth", "", "true", ""), ("hostile", HOSTILE, "true", "")]
    names = [row[0] for row in rows[3:]] + [f"flight {i}" for i in range(count - len(rows))]
    for seed, name in enumerate(names):
        simulate(folder / name, seed, "--duration", str(duration_s), "--rate", "20")
    (folder / "no truth" / "ground_truth.csv").unlink()
    (folder / "wrong.yaml").write_text("tag_map:\n  grid: {rows: 12, columns: 9, tag_size_m: 0.152, row_gaps_m: 0.3, "
                                       "column_gaps_m: 0.3}\n", encoding="utf-8")
    rows += [(name, "", "true", "") for name in names[3:]]
    lines = ["recording,name,use_detections,map"]
    lines += [",".join('"' + cell.replace('"', '""') + '"' for cell in row) for row in rows]
    (folder / "list.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def command(recordings, output, jobs=2, more=()):
    return [str(PROGRAMS / "tagtwist_fleet"), "--recordings", str(recordings), "--output", str(output), "--jobs",
            str(jobs), *more]


def run_fleet(recordings, output, jobs=2, more=(), environment=None):
    return subprocess.run(command(recordings, output, jobs, more), capture_output=True, text=True, check=False,
                          env=environment, stdin=subprocess.DEVNULL)


def records(output):
    out = {}
    for path in sorted((pathlib.Path(output) / "records").glob("*.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        out[path.stem] = record
    return out


def rows(output):
    table = json.loads((pathlib.Path(output) / "fleet.json").read_text(encoding="utf-8"))
    return {row["recording"]: row for row in table["rows"]}


def result_bytes(output):
    """The bytes of all results, by recording and file."""
    out = {}
    for name, row in rows(output).items():
        for file in BYTES:
            path = pathlib.Path(row["folder"]) / file
            if path.exists():
                out[name, file] = path.read_bytes()
    return out


def half_files(output):
    """What something that was ended may have left."""
    return [str(path) for path in pathlib.Path(output).rglob(".*")
            if any(mark in path.name for mark in (".partial", ".commit", ".part-"))]


def descendants(pid):
    """Process ids of all that a process has begun, itself first."""
    out, children = [], {}
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            status = pathlib.Path("/proc", entry, "stat").read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        children.setdefault(int(status.rsplit(")", 1)[1].split()[1]), []).append(int(entry))
    waiting = [pid]
    while waiting:
        out.append(waiting.pop())
        waiting += children.get(out[-1], [])
    return out


def kill_all(process):
    """SIGKILL for a process and all that it has begun."""
    for pid in descendants(process.pid):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    process.wait()


def wait_until(condition, seconds, what):
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            sys.exit(f"not within {seconds} s: {what}")
        time.sleep(0.05)
