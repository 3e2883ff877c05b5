"""A short flight that tagtwist_simulate renders, and what the programs say of it."""
import csv
import json
import os
import subprocess
import tempfile

import numpy as np

PROGRAMS = os.environ["TAGTWIST_PROGRAM_DIR"]
SOURCE = os.environ["TAGTWIST_SOURCE_DIR"]


def run(folder, program, *arguments):
    """Runs a program, and returns what it prints."""
    done = subprocess.run([os.path.join(PROGRAMS, program), *arguments], cwd=folder, text=True,
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


class Flight:
    """The recording `path` with images and detections, in a folder of its own."""

    def __init__(self, trajectory="figure8"):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = self._folder.name
        self.path = os.path.join(self.folder, "flight")
        run(self.folder, "tagtwist_simulate", "--output", self.path, "--trajectory", trajectory,
            "--duration", "1", "--rate", "30")

    def remove(self):
        self._folder.cleanup()

    def estimate(self, name, *arguments):
        """Output folder of tagtwist_estimate."""
        run(self.folder, "tagtwist_estimate", "--dataset", self.path, "--output", name,
            "--write_covariance", *arguments)
        return os.path.join(self.folder, name)

    def compare(self, *arguments):
        """{name: input} of tagtwist_compare --json."""
        run(self.folder, "tagtwist_compare", *arguments, "--json", "compare.json")
        with open(os.path.join(self.folder, "compare.json"), encoding="utf-8") as file:
            return {row["name"]: row for row in json.load(file)["inputs"]}


def read_columns(path):
    """{column: values} of a CSV file, NaN where a cell is empty."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(columns, *names):
    """(N, len(names)) of the columns."""
    return np.array([[float(cell) if cell else np.nan for cell in columns[name]]
                     for name in names]).T
