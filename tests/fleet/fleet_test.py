"""tagtwist_fleet over 24 recordings with faults among them: one table, killed and resumed, changed and run again."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import fleet_fixture as fixture  # noqa: E402


class Fleet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tagtwist fleet '"))
        cls.list = cls.folder / "recordings" / "list.csv"
        fixture.make_recordings(cls.folder / "recordings")
        cls.first = fixture.run_fleet(cls.list, cls.folder / "out")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def times(self, output):
        """When each result came: another run would change it."""
        return {path: (path.stat().st_mtime_ns, path.stat().st_ino)
                for path in sorted((output / "runs").glob("*/states.csv"))}

    def expect_done(self, recordings, output, more=()):
        run = fixture.run_fleet(recordings, output, more=more)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_one_table_names_each_fault(self):
        self.assertEqual(self.first.returncode, 1, self.first.stderr)
        self.assertIn("3 of 24 recordings failed", self.first.stderr.splitlines()[-1])
        rows = fixture.rows(self.folder / "out")
        self.assertEqual(len(rows), 24)
        for name, fault in fixture.FAULTS.items():
            self.assertEqual(rows[name]["outcome"], "failed")
            self.assertIn(fault, rows[name]["error"])
        done = [row for row in rows.values() if row["outcome"] == "done"]
        self.assertEqual(len(done), 21)
        self.assertIsNone(rows["no truth"]["position_rmse_m"])
        self.assertEqual(sum(row["position_rmse_m"] is None for row in done), 1)
        self.assertEqual(rows[fixture.HOSTILE]["outcome"], "done")
        page = (self.folder / "out" / "fleet.html").read_text(encoding="utf-8")
        self.assertNotIn("<script>alert", page)
        self.assertIn("&lt;script&gt;alert(1)", page)
        self.assertEqual(list(pathlib.Path(self.folder).rglob("pwned")), [])

    def test_it_is_what_each_run_alone_gives(self):
        row = fixture.rows(self.folder / "out")["flight 3"]
        fixture.call("tagtwist_estimate", "--dataset", self.folder / "recordings" / "flight 3", "--use_detections",
                     "--output", self.folder / "alone")
        for name in fixture.BYTES:
            self.assertEqual((self.folder / "alone" / name).read_bytes(),
                             (pathlib.Path(row["folder"]) / name).read_bytes())

    def test_killed_in_the_middle_it_goes_on(self):
        output = self.folder / "killed"
        process = subprocess.Popen(fixture.command(self.list, output), stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        fixture.wait_until(lambda: len(fixture.records(output)) >= 8, 100, "eight recordings")
        fixture.kill_all(process)
        (output / "records" / ".x.json.part-abc").write_text("{", encoding="utf-8")  # as if in the middle of it
        before = fixture.records(output)
        self.assertLess(len(before), 24, "it was not in the middle")
        done = {name for name, record in before.items() if record["outcome"] == "done"}
        times = {path: when for path, when in self.times(output).items() if path.parent.name in done}
        run = fixture.run_fleet(self.list, output)
        self.assertEqual(run.returncode, 1, run.stderr)
        after = self.times(output)
        self.assertEqual({path: after[path] for path in times}, times, "done twice")
        self.assertEqual(fixture.half_files(output), [])
        self.assertEqual(fixture.result_bytes(output), fixture.result_bytes(self.folder / "out"))

    def test_what_changed_is_run_again_and_nothing_else(self):
        output, recordings = self.folder / "again", self.folder / "few"
        for name in ("flight 0", "flight 1", "flight 2"):
            shutil.copytree(self.folder / "recordings" / name, recordings / name)
        shutil.copytree(self.folder / "recordings" / "flight 3", recordings / os.fsdecode(b"no \xff text\n"))
        config = self.folder / "mine.yaml"
        config.write_text("detector:\n  border_px: 3\n", encoding="utf-8")
        more = ("--config", str(config), "--", "--use_detections")
        self.expect_done(recordings, output, more)
        times = self.times(output)
        self.expect_done(recordings, output, more)
        self.assertEqual(self.times(output), times)
        truth = recordings / "flight 1" / "ground_truth.csv"
        truth.write_text("\n".join(truth.read_text(encoding="utf-8").splitlines()[:-1]) + "\n", encoding="utf-8")
        dry = fixture.run_fleet(recordings, output, more=("--dry_run", *more))
        self.assertEqual(dry.stdout, "flight 1: changed: what it reads\n1 of 4 recordings would be run\n")
        self.expect_done(recordings, output, more)
        changed = {path.parent.name[:8] for path, when in self.times(output).items() if times[path] != when}
        self.assertEqual(changed, {"flight_1"})
        config.write_text("detector:\n  border_px: 4\n", encoding="utf-8")
        dry = fixture.run_fleet(recordings, output, more=("--dry_run", *more))
        self.assertIn("4 of 4", dry.stdout)

    def test_pieces_of_images_give_the_same_bytes(self):
        outputs = []
        for pieces in (1, 3):
            listed = self.folder / f"pieces{pieces}.csv"
            listed.write_text(f"recording,pieces\nrecordings/rendered,{pieces}\n", encoding="utf-8")
            outputs.append(self.folder / f"of {pieces}")
            self.expect_done(listed, outputs[-1])
        self.assertEqual(len(list((outputs[1] / "logs").glob("*.00?.txt"))), 3)
        # What is left of pieces that were others does not count.
        left = outputs[1] / "pieces" / next((outputs[1] / "jobs").glob("*.json")).stem
        (left / "007").mkdir(parents=True)
        (left / "007" / "piece.json").write_text("{}", encoding="utf-8")
        listed.write_text("recording,pieces\nrecordings/rendered,2\n", encoding="utf-8")
        self.expect_done(listed, outputs[1])
        self.assertEqual(fixture.result_bytes(outputs[0]), fixture.result_bytes(outputs[1]))

    def test_a_program_that_is_killed_is_tried_again(self):
        """A flag that cannot be is a fault of the recording; a signal is not."""
        listed = self.folder / "signal.csv"
        listed.write_text("recording,use_detections\nrecordings/flight 0,true\n", encoding="utf-8")
        programs = self.folder / "programs"
        shutil.copytree(fixture.PROGRAMS.parent / "share", programs / "share")
        (programs / "apps").mkdir()
        for name in ("tagtwist_fleet", "tagtwist_compare"):
            shutil.copy(fixture.PROGRAMS / name, programs / "apps" / name)
        (programs / "apps" / "tagtwist_estimate").write_text(
            f"""#!/bin/sh
case "$*" in *--output=*) echo x >>"{self.folder}/attempts"
[ $(wc -l <"{self.folder}/attempts") -ge 3 ] || kill -9 $$ ;; esac
exec "{fixture.PROGRAMS}/tagtwist_estimate" "$@"
""", encoding="utf-8")
        (programs / "apps" / "tagtwist_estimate").chmod(0o755)
        output = self.folder / "signalled"
        run = subprocess.run([programs / "apps" / "tagtwist_fleet", "--recordings", listed, "--output", output],
                             capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual((self.folder / "attempts").read_text(encoding="utf-8"), "x\n" * 3)
        (self.folder / "attempts").unlink()
        run = subprocess.run([programs / "apps" / "tagtwist_fleet", "--recordings", listed, "--output",
                              self.folder / "given up", "--retries", "1"], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 1)
        row = json.loads((self.folder / "given up" / "fleet.json").read_text(encoding="utf-8"))["rows"][0]
        self.assertEqual((row["outcome"], row["error"]), ("unfinished", "ended by signal 9"))


if __name__ == "__main__":
    if fixture.missing():
        print("skipped:", fixture.missing())
        sys.exit(fixture.SKIP)
    unittest.main()
