"""What the engine runs: run_recording.py chunk|piece OUTPUT NAME. Exits with 0 where all that NAME stands for has a
result, or failed in a way that it would fail in again; with 1 where a run was ended and is worth another attempt."""
import fcntl
import pathlib
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from fleet_plan import digest_of, read_json, to_json, write_whole  # noqa: E402

FIRST_STATUS_OF_A_SHELL = 126  # the program was not there, or a signal ended it


def last_line(text):
    lines = [line for line in text.splitlines() if line.strip()]
    line = lines[-1] if lines else "ended without a word"
    return line.removeprefix("tagtwist_estimate: ")


def run_estimate(arguments, log):
    """(outcome, error, wall seconds) of the program; all that it prints is in the log."""
    start = time.monotonic()
    log.write(f"\n== {' '.join(arguments)}\n".encode("utf-8", "surrogateescape"))
    log.flush()
    try:
        done = subprocess.run(arguments, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.PIPE, check=False)
    except OSError as error:
        return "unfinished", f"{arguments[0]}: {error.strerror}", 0.0
    wall_s = time.monotonic() - start
    told = done.stderr.decode("utf-8", "surrogateescape")
    log.write(done.stderr)
    log.flush()
    if done.returncode == 0:
        return "done", "", wall_s
    if done.returncode < 0:
        return "unfinished", f"ended by signal {-done.returncode}", wall_s
    outcome = "unfinished" if done.returncode >= FIRST_STATUS_OF_A_SHELL else "failed"
    return outcome, last_line(told), wall_s


class Recording:
    """A row of the list, its job and its places in the output folder."""

    def __init__(self, output, row_id):
        self.output, self.id = output, row_id
        self.job = read_json(output / "jobs" / f"{row_id}.json")
        self.record = output / "records" / f"{row_id}.json"
        self.pieces = output / "pieces" / row_id

    def is_settled(self):
        known = read_json(self.record) or {}
        return known.get("job") == digest_of(self.job) and known.get("outcome") in ("done", "failed")

    def write(self, outcome, error, wall_s):
        write_whole(self.record, to_json({
            "job": digest_of(self.job), "name": self.job["name"], "outcome": outcome, "error": error,
            "wall_s": round(wall_s, 3), "version": self.job["version"],
            "program_sha256": self.job["program_sha256"]}))

    def open_log(self):
        """Its lock goes with the program that inherits it: whoever comes next waits for what a killed engine left."""
        path = self.output / "logs" / f"{self.id}.txt"
        path.parent.mkdir(parents=True, exist_ok=True)
        log = open(path, "ab")
        fcntl.flock(log, fcntl.LOCK_EX)
        return log


def piece_names(job):
    return [f"{k:03d}" for k in range(job["pieces"])]


def mark(k, pieces):
    """Where piece k begins. The same text for the piece before, which ends there."""
    return f"{100 * k / pieces:.6f}%"


def run_piece(output, name):
    row_id, piece = name.rsplit(".", 1)
    recording = Recording(output, row_id)
    job, k = recording.job, int(piece)
    state = recording.pieces / f"{piece}.json"
    known = read_json(state) or {}
    if known.get("job") == digest_of(job) and (recording.pieces / piece / "piece.json").is_file():
        return True
    for folder in (output / "logs", recording.pieces):
        folder.mkdir(parents=True, exist_ok=True)
    with open(output / "logs" / f"{row_id}.{piece}.txt", "ab") as log:
        outcome, error, wall_s = run_estimate(
            [job["program"], *job["arguments"], "--only_detections", f"--from={mark(k, job['pieces'])}",
             f"--to={mark(k + 1, job['pieces'])}", f"--output={recording.pieces / piece}"], log)
    write_whole(state, to_json({"job": digest_of(job), "outcome": outcome, "error": error,
                                "wall_s": round(wall_s, 3)}))
    return outcome != "unfinished"


def joined(recording):
    """(error, flags) to estimate from the pieces."""
    if recording.job["pieces"] == 1:
        return "", []
    for name in piece_names(recording.job):
        state = read_json(recording.pieces / f"{name}.json") or {}
        if state.get("outcome") != "done":
            return state.get("error") or "a piece of it is missing", []
    return "", [f"--pieces={recording.pieces}"]


def run_recording(output, row_id):
    recording = Recording(output, row_id)
    with recording.open_log() as log:
        if recording.is_settled():
            return True
        error, flags = joined(recording)
        outcome, wall_s = "failed", 0.0
        if not error:
            outcome, error, wall_s = run_estimate(
                [recording.job["program"], *recording.job["arguments"], *flags,
                 f"--output={output / 'runs' / row_id}"], log)
        recording.write(outcome, error, wall_s)
    if outcome == "done" and recording.pieces.exists():
        shutil.rmtree(recording.pieces)
    return outcome != "unfinished"


def main():
    kind, output, name = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), sys.argv[3]
    if kind == "piece":
        return 0 if run_piece(output, name) else 1
    plan = read_json(output / ".fleet" / "plan.json")
    settled = [run_recording(output, row_id) for row_id in plan["chunks"][name]]
    return 0 if all(settled) else 1


if __name__ == "__main__":
    sys.exit(main())
