"""Lists, plans and refusals of tagtwist_fleet: what needs no engine."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import fleet_fixture as fixture  # noqa: E402

sys.path.insert(0, str(fixture.PROGRAMS.parent / "share" / "tagtwist" / "fleet"))
import fleet_fault  # noqa: E402
import fleet_list  # noqa: E402
import fleet_main  # noqa: E402
import fleet_plan  # noqa: E402

FLAGS = fleet_list.flags_of(fixture.PROGRAMS / "tagtwist_estimate")


class Lists(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tagtwist-list-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def rows(self, text):
        path = self.folder / "list.csv"
        path.write_text(text, encoding="utf-8")
        return fleet_list.rows_of(path, FLAGS)

    def fleet(self, *arguments):
        return subprocess.run([str(fixture.PROGRAMS / "tagtwist_fleet"), *map(str, arguments)], capture_output=True,
                              text=True, check=False, cwd=self.folder)

    def assert_refused(self, fault, text):
        with self.assertRaises(fleet_fault.Fault) as raised:
            self.rows(text)
        self.assertIn(fault, str(raised.exception))

    def test_flags_come_from_the_program(self):
        self.assertLessEqual({"camera_file", "map", "ground_truth", "config", "threads", "corner_sigma_px"}, FLAGS)
        self.assertFalse({"output", "dataset", "only_detections", "pieces", "overlay", "stream", "record", "help"} & FLAGS)

    def test_cells_become_flags_and_paths_are_the_lists(self):
        row, = self.rows("recording,map,corner_sigma_px,config\na b,m.yaml,0.1,\n")
        self.assertEqual(row.recording, str(self.folder.resolve() / "a b"))
        self.assertEqual(row.flags, {"map": str(self.folder.resolve() / "m.yaml"), "corner_sigma_px": "0.1"})
        self.assertEqual(row.swept, {})

    def test_several_values_are_swept_over(self):
        rows = self.rows("recording,corner_sigma_px,threads\nx,0.1 | 0.2,1|2\ny,0.1,1\n")
        self.assertEqual(len(rows), 5)
        self.assertEqual(len({row.id for row in rows}), 5)
        self.assertEqual({row.swept["corner_sigma_px"] for row in rows}, {"0.1", "0.2"})
        row, = self.rows("recording,topic\nx,a\\|b\n")
        self.assertEqual(row.flags["topic"], "a|b")

    def test_names_that_are_hostile_are_plain_for_the_engine(self):
        for name in (fixture.HOSTILE, "../..", "--output", "", "é ü", "$(x)", "a\tb"):
            row = fleet_list.Row(name, "x")
            self.assertRegex(row.id, r"^[A-Za-z0-9_]+-[0-9a-f]{10}$")

    def test_a_rows_id_does_not_depend_on_its_place_or_flags(self):
        first = self.rows("recording,map\nx,a\ny,a\n")[1].id
        self.assertEqual(self.rows("recording,map\ny,b\n")[0].id, first)

    def test_wrong_lists_are_told_with_file_and_line(self):
        self.assert_refused("list.csv:1: column 'cameras_file': expected recording, name, pieces, or a flag of "
                            "tagtwist_estimate that says what to read or how, did you mean camera_file?", "recording,cameras_file\nx,1\n")
        self.assert_refused("list.csv:1: expected a column 'recording'", "map\nx\n")
        self.assert_refused("list.csv:1: column 'output': expected recording, name, pieces, or a flag", "recording,output\nx,y\n")
        self.assert_refused("list.csv:1: column 'map' is there twice", "recording,map,map\nx,y,z\n")
        self.assert_refused("list.csv:3: expected 2 columns, got 1", "recording,map\nx,y\nz\n")
        self.assert_refused("list.csv:3: 'x' is listed twice, first in line 2", "recording\nx\nx\n")
        self.assert_refused("list.csv:2: pieces: expected 1 to 999, got '0'", "recording,pieces\nx,0\n")
        self.assert_refused("list.csv: no rows", "recording\n")
        self.assert_refused("list.csv: cannot read: ", 'recording\n"x\n')

    def test_a_folders_recordings(self):
        (self.folder / "all" / "flight").mkdir(parents=True)
        (self.folder / "all" / "flight" / "timestamps.csv").write_text("t,file\n", encoding="utf-8")
        (self.folder / "all" / "notes").mkdir()
        for name in ("a.mp4", "b.MAT", "readme.txt", ".hidden.mp4"):
            (self.folder / "all" / name).write_text("", encoding="utf-8")
        rows = fleet_list.rows_of(self.folder / "all", FLAGS)
        self.assertEqual([row.name for row in rows], ["a.mp4", "b.MAT", "flight"])

    def test_what_the_result_depends_on_changes_the_job(self):
        (self.folder / "rec").mkdir()
        (self.folder / "rec" / "timestamps.csv").write_text("t,file\n", encoding="utf-8")
        (self.folder / "cam.yaml").write_text("camera: 1\n", encoding="utf-8")
        (self.folder / "c.yaml").write_text("camera: {file: cam.yaml}\n", encoding="utf-8")
        row, = self.rows("recording,config\nrec,c.yaml\n")

        def digest(version="1", program="p"):
            return fleet_plan.digest_of(fleet_plan.job_of(row, program, version, "sha"))
        before = digest()
        self.assertEqual(digest(program="elsewhere"), before)
        self.assertNotEqual(digest(version="2"), before)
        (self.folder / "cam.yaml").write_text("camera: 2\n", encoding="utf-8")  # named by the configuration
        changed = digest()
        self.assertNotEqual(changed, before)
        (self.folder / "rec" / "new.png").write_text("", encoding="utf-8")
        self.assertNotEqual(digest(), changed)

    def test_chunks_hold_each_recording_once_and_long_ones_alone(self):
        rows = [fleet_list.Row(str(i), "x", pieces=3 if i == 4 else 1) for i in range(10)]
        chunks = fleet_plan.chunks_of(rows, 4)
        self.assertEqual(sorted(len(chunk) for chunk in chunks.values()), [1, 1, 4, 4])
        self.assertEqual(sorted(row.name for chunk in chunks.values() for row in chunk), sorted(str(i) for i in range(10)))

    def test_wrong_use_is_one_line_and_status_2(self):
        for arguments, fault in ((["--recordings", "x"], "--output"), (["--recording", "x", "--output", "y"], ""),
                                 (["--recordings", "x", "--output", "y", "--jobs", "0"], "--jobs"),
                                 (["--recordings", "x", "--output", "y", "z"], "z")):
            run = self.fleet(*arguments)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
            self.assertIn(fault, run.stderr)
        run = self.fleet("--recordings", "absent", "--output", "y")
        self.assertEqual((run.returncode, run.stderr),
                         (1, "tagtwist_fleet: absent: cannot open: No such file or directory\n"))

    def test_inputs_are_never_outputs(self):
        (self.folder / "all" / "rec").mkdir(parents=True)
        (self.folder / "all" / "rec" / "timestamps.csv").write_text("t,file\n", encoding="utf-8")
        (self.folder / "mine").mkdir()
        (self.folder / "mine" / "thesis.tex").write_text("", encoding="utf-8")
        (self.folder / "mine" / "list.csv").write_text("recording\n../all/rec\n", encoding="utf-8")
        for recordings, output, fault in (("all", "all", "would write among"), ("all", "all/rec/out", "lies in the recording"),
                                          ("all", "mine", "is not empty, and not of a fleet"),
                                          ("mine/list.csv", "mine", "would overwrite it")):
            run = self.fleet("--recordings", recordings, "--output", output, "--dry_run")
            self.assertEqual(run.returncode, 1)
            self.assertIn(fault, run.stderr)
        self.assertEqual(sorted(p.name for p in (self.folder / "mine").iterdir()), ["list.csv", "thesis.tex"])

    def test_without_the_engine_nothing_is_begun(self):
        (self.folder / "rec").mkdir()
        (self.folder / "rec" / "timestamps.csv").write_text("t,file\n", encoding="utf-8")
        (self.folder / "list.csv").write_text("recording\nrec\n", encoding="utf-8")
        run = subprocess.run([str(fixture.PROGRAMS / "tagtwist_fleet"), "--recordings", "list.csv", "--output", "out"],
                             capture_output=True, text=True, check=False, cwd=self.folder, env={"PATH": "/nowhere"})
        self.assertEqual(run.returncode, 1)
        self.assertTrue(run.stderr.startswith("tagtwist_fleet: snakemake is not installed: "), run.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_the_man_page_has_every_flag(self):
        page = (pathlib.Path(__file__).parents[2] / "apps" / "fleet" / "tagtwist_fleet.1").read_text(encoding="utf-8")
        for action in fleet_main.make_parser()._actions:
            for flag in action.option_strings:
                if flag.startswith("--"):
                    self.assertIn(flag.replace("-", "\\-"), page)


if __name__ == "__main__":
    unittest.main()
