"""The code of docs/python.md runs as it stands, beside a recording called flight; so does that of docs/live.md."""
import os
import re
import sys
import types
import unittest

from flight import SOURCE, Flight


class Docs(unittest.TestCase):
    def setUp(self):
        flight = Flight("hover")
        self.addCleanup(flight.remove)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(flight.folder)

    def test_code_runs(self):
        with open(f"{SOURCE}/docs/python.md", encoding="utf-8") as file:
            lines = re.findall(r"^    (.*)$", file.read(), re.MULTILINE)
        names = {}
        exec("\n".join(lines), names)  # pylint: disable=exec-used
        self.assertEqual(names["smoothed"].t_ns.tolist(), names["result"].t_ns.tolist())
        self.assertLess(names["figures"]["optimised"]["position_rmse_m"], 1e-3)
        self.assertLess(names["figures"]["optimised"]["nees"]["per_dof"], 10)
        self.assertEqual(len(names["from_tags"]), len(names["result"]))

    def test_the_example_of_live_plots(self):
        with open(f"{SOURCE}/docs/live.md", encoding="utf-8") as file:
            section = file.read().split("## Python")[1].split("## ")[0]
        code = "\n".join(re.findall(r"^    (.*)$", section, re.MULTILINE))
        self.assertEqual(code.count("\n"), 9)  # ten lines
        drawn, matplotlib = [], types.ModuleType("matplotlib")
        matplotlib.pyplot = types.ModuleType("matplotlib.pyplot")
        for name, does in {"figure": lambda: types.SimpleNamespace(clear=lambda: None), "pause": lambda s: None,
                           "plot": lambda t, z: drawn.append((t, z)), "fill_between": lambda t, low, high, alpha: drawn.append((t, low, high))}.items():
            setattr(matplotlib.pyplot, name, does)
        sys.modules.update({"matplotlib": matplotlib, "matplotlib.pyplot": matplotlib.pyplot})
        self.addCleanup(lambda: [sys.modules.pop(name) for name in ("matplotlib", "matplotlib.pyplot")])
        exec(code.replace('"camera:0"', '"flight"').replace('"mine.yaml"', f'"{SOURCE}/configs/course.yaml"'), {})
        self.assertGreaterEqual(len(drawn), 2)
        (_, low, high), (t, z) = drawn[-2:]
        self.assertGreater(len(t), 4)
        self.assertTrue(all(a < b < c and abs(b - 1.2) < 0.1 for a, b, c in zip(low, z, high)))


if __name__ == "__main__":
    unittest.main()
