"""The code of docs/python.md runs as it stands, beside a recording called flight."""
import os
import re
import unittest

from flight import SOURCE, Flight


class Docs(unittest.TestCase):
    def test_code_runs(self):
        flight = Flight("hover")
        self.addCleanup(flight.remove)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(flight.folder)
        with open(f"{SOURCE}/docs/python.md", encoding="utf-8") as file:
            lines = re.findall(r"^    (.*)$", file.read(), re.MULTILINE)
        names = {}
        exec("\n".join(lines), names)  # pylint: disable=exec-used
        self.assertEqual(names["smoothed"].t_ns.tolist(), names["result"].t_ns.tolist())
        self.assertLess(names["figures"]["optimised"]["position_rmse_m"], 1e-3)
        self.assertLess(names["figures"]["optimised"]["nees"]["per_dof"], 10)
        self.assertEqual(len(names["from_tags"]), len(names["result"]))


if __name__ == "__main__":
    unittest.main()
