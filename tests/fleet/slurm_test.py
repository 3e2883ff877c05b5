"""The fleet of fleet_test.py through a real Slurm on loopback: the same bytes as without, a job that is killed and tried
again, a node that is drained and resumed."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
import fleet_fixture as fixture  # noqa: E402
import loopback_slurm  # noqa: E402


def processes_of(program, output):
    """Ids of the program's processes that work for this output."""
    out = []
    for entry in pathlib.Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except (OSError, NotADirectoryError):
            continue
        if words[0].endswith(program.encode()) and any(str(output).encode() in word for word in words):
            out.append(int(entry.name))
    return out


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tagtwist-slurm-"))
        cls.folder.chmod(0o755)  # munged's user looks into it
        cls.list = cls.folder / "recordings" / "list.csv"
        fixture.make_recordings(cls.folder / "recordings")
        cls.slurm = loopback_slurm.LoopbackSlurm(cls.folder / "slurm", cores=2).__enter__()
        # Snakemake asks every second instead of every ten.
        cls.environment = dict(cls.slurm.environment, CI="true")

    @classmethod
    def tearDownClass(cls):
        cls.slurm.__exit__()
        shutil.rmtree(cls.folder)

    def jobs(self):
        """States of all jobs that Slurm knows, by id."""
        told = self.slurm.call("squeue", "--noheader", "--states=all", "--format=%i %T")
        return dict(line.split() for line in told.splitlines())

    def start(self, output, *more):
        return subprocess.Popen(
            fixture.command(self.list, output, 2, ("--profile", "slurm", *more)), env=self.environment,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL)

    def test_the_same_bytes_and_a_drained_node_is_waited_for(self):
        here = self.folder / "here"
        self.assertEqual(fixture.run_fleet(self.list, here).returncode, 1)
        before, output = set(self.jobs()), self.folder / "there"
        self.slurm.call("scontrol", "update", f"nodename={self.slurm.host}", "state=drain", "reason=test")
        process = self.start(output, "--group", "8")
        fixture.wait_until(lambda: "PENDING" in self.jobs().values(), 60, "a job that waits")
        time.sleep(3)
        self.assertEqual(fixture.records(output), {}, "a drained node works")
        self.slurm.call("scontrol", "update", f"nodename={self.slurm.host}", "state=resume")
        _, told = process.communicate(timeout=200)
        self.assertEqual(process.returncode, 1, told)
        self.assertIn("3 of 24 recordings failed", told)
        self.assertEqual(fixture.result_bytes(output), fixture.result_bytes(here))
        self.assertEqual(fixture.half_files(output), [])
        states = [state for job, state in self.jobs().items() if job not in before]
        self.assertEqual(states, ["COMPLETED"] * 3, "24 recordings in groups of 8")

    def test_a_job_that_is_killed_is_tried_again(self):
        before, output = set(self.jobs()), self.folder / "killed"
        process = self.start(output, "--group", "12")
        fixture.wait_until(lambda: len(fixture.records(output)) >= 3, 100, "three recordings")
        job = sorted(set(self.jobs()) - before)[0]
        times = {path: path.stat().st_mtime_ns for path in (output / "records").glob("*.json")}
        self.slurm.call("scancel", "--signal=KILL", "--full", job)
        _, told = process.communicate(timeout=200)
        self.assertEqual(process.returncode, 1, told)
        self.assertIn("3 of 24 recordings failed", told)
        states = {self.jobs()[new] for new in set(self.jobs()) - before}
        self.assertIn("COMPLETED", states)
        self.assertGreater(len(states), 1, "no job was killed")
        self.assertEqual({path: path.stat().st_mtime_ns for path in times}, times, "done twice")
        self.assertEqual(processes_of("tagtwist_estimate", output), [])


if __name__ == "__main__":
    fault = fixture.missing() or loopback_slurm.missing()
    if fault:
        print("skipped:", fault)
        sys.exit(fixture.SKIP)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # ctest's timeout: the daemons end, too
    os.umask(0o022)
    unittest.main()
