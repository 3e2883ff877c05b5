"""Calls Snakemake with the workflow, and tells how far it is."""
import ctypes
import fcntl
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

from fleet_fault import Fault
from fleet_plan import read_json, to_json, write_whole

HERE = pathlib.Path(__file__).resolve().parent
LOOK_S = 0.2


class Progress:
    """One line on a terminal; elsewhere a line a recording."""

    def __init__(self, output, rows):
        self.output, self.waiting, self.total = output, {row.id: row for row in rows}, len(rows)
        self.failed, self.on_terminal = 0, sys.stderr.isatty()
        self.digests = {row.id: None for row in rows}

    def expect(self, digests):
        self.digests = digests

    def look(self):
        for row_id, row in list(self.waiting.items()):
            record = read_json(self.output / "records" / f"{row_id}.json") or {}
            if record.get("job") != self.digests[row_id] or record.get("outcome") not in ("done", "failed"):
                continue
            del self.waiting[row_id]
            self.tell(row, record)

    def tell(self, row, record):
        failed = record["outcome"] == "failed"
        self.failed += failed
        count = f"{self.total - len(self.waiting)}/{self.total}"
        text = f"{count} {printable(row.name)}" + (f": {printable(record['error'])}" if failed else "")
        if self.on_terminal and not failed:
            print(f"\r\033[K{count} recordings, {self.failed} failed", end="", file=sys.stderr, flush=True)
        else:
            print(("\r\033[K" if self.on_terminal else "") + text, file=sys.stderr, flush=True)

    def end(self):
        if self.on_terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def printable(text):
    """Nothing that a terminal would obey."""
    text = text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
    return "".join(c if c.isprintable() else "?" for c in text)


def lock(output):
    """Held until this process ends, however it ends."""
    folder = output / ".fleet"
    folder.mkdir(parents=True, exist_ok=True)
    file = open(folder / "lock", "a", encoding="utf-8")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise Fault(f"{output}: another tagtwist_fleet is at work there") from error
    return file


def profile_folder(profile):
    """The folder of a profile; None: this machine."""
    if profile == "local":
        return None
    shipped = HERE / "profiles" / profile
    folder = shipped if shipped.is_dir() and os.sep not in profile else pathlib.Path(profile)
    if not (folder / "config.yaml").is_file():
        raise Fault(f"--profile: expected local, slurm or a folder with a config.yaml, got '{profile}'", 2)
    return folder.resolve()


def command_of(output, options, profile):
    """Snakemake's command line."""
    out = ["snakemake", "--snakefile", str(HERE / "Snakefile"), "--directory", str(output / ".fleet"),
           "--config", "plan=plan.json", "--nolock", "--keep-going", "--rerun-triggers", "mtime",
           "--scheduler", "greedy", "--nocolor", "--rerun-incomplete"]
    if profile is None:
        return out + ["--cores", str(options.jobs)]
    return out + ["--profile", str(profile), "--jobs", str(options.jobs)]


def end_with_me():
    """The engine is told to end when this program is gone, however it went: nothing works on without a lock."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def write_plan(output, chunks, options):
    from run_recording import piece_names  # the names that it looks for
    jobs = {row.id: {"pieces": row.pieces} for rows in chunks.values() for row in rows}
    write_whole(output / ".fleet" / "plan.json", to_json({
        "runner": str(HERE / "run_recording.py"), "python": sys.executable, "threads": options.threads,
        "retries": options.retries, "mem_mb": options.mem_mb, "minutes": options.minutes,
        "chunks": {name: [row.id for row in rows] for name, rows in chunks.items()},
        "pieces": {name: [f"{row.id}.{piece}" for row in rows if row.pieces > 1
                          for piece in piece_names(jobs[row.id])] for name, rows in chunks.items()}}))


def check_installed():
    if shutil.which("snakemake") is None:
        raise Fault("snakemake is not installed: apt-get install snakemake (scripts/setup fleet)")


def run(output, chunks, digests, options):
    """Runs the chunks; what came of each is in records/."""
    profile = profile_folder(options.profile)
    for name in ("chunks", "pieces"):  # the engine's marks of an earlier run; results are known by records/
        shutil.rmtree(output / ".fleet" / name, ignore_errors=True)
    for folder in (output / ".fleet" / "slurm", output / "runs", output / "records", output / "logs"):
        folder.mkdir(parents=True, exist_ok=True)
    write_plan(output, chunks, options)
    progress = Progress(output, [row for rows in chunks.values() for row in rows])
    progress.expect(digests)
    environment = dict(os.environ, PYTHONDONTWRITEBYTECODE="1", XDG_CACHE_HOME=str(output / ".fleet" / "cache"))
    with open(output / ".fleet" / "snakemake.txt", "ab") as log:
        engine = subprocess.Popen(command_of(output, options, profile), stdin=subprocess.DEVNULL, stdout=log,
                                  stderr=subprocess.STDOUT, env=environment, preexec_fn=end_with_me)
        try:
            while engine.poll() is None:
                progress.look()
                time.sleep(LOOK_S)
        except KeyboardInterrupt:
            engine.wait()  # it has the same signal, and ends its jobs
            raise
    progress.look()
    progress.end()
    return engine.returncode
