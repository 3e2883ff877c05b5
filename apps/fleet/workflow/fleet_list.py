"""The list of recordings: rows of names and flags, from a folder or from LIST.csv."""
import csv
import difflib
import hashlib
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys
from dataclasses import dataclass, field

from fleet_fault import Fault

VIDEOS_AND_FILES = {".mp4", ".avi", ".mkv", ".mov", ".m4v", ".webm", ".bag", ".mat", ".db3", ".mcap"}
IMAGES = {".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff"}
MARKS = {"timestamps.csv", "detections.csv", "mav0", "cam0", "metadata.yaml"}
OWN_COLUMNS = ("recording", "name", "pieces")
PATHS = ("config", "camera_file", "map", "ground_truth")
# What a fleet gives itself; and of what writes or serves beside the results nothing but these.
NOT_IN_A_LIST = ("dataset", "pieces", "realtime", "fail_on", "help", "man", "version")
GROUPS_THAT_WRITE = ("What to write", "While it runs")
WRITTEN_ALL_THE_SAME = ("write_covariance", "write_detections")


@dataclass
class Row:
    """One run: a recording with one value a flag."""
    name: str                 # as people call it: the column `name`, or the recording as listed
    recording: str            # where it is
    flags: dict = field(default_factory=dict)   # of tagtwist_estimate, by name
    swept: dict = field(default_factory=dict)   # those of them that have several values in the list
    pieces: int = 1

    @property
    def id(self):
        """A name for files and for the engine, the same whenever name and swept values are."""
        slug = re.sub(r"[^A-Za-z0-9_]+", "_", pathlib.PurePath(self.name).name)[:40].strip("_")
        text = json.dumps([self.name, sorted(self.swept.items())])
        digest = hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()
        return f"{slug or 'recording'}-{digest[:10]}"


def flags_of(program):
    """Names of the program's flags, from its own help."""
    help_text = subprocess.run([str(program), "--help"], capture_output=True, text=True, check=True).stdout
    flags, group = set(), ""
    for line in help_text.splitlines():
        found = re.match(r"  --([a-z0-9_]+)", line)
        if not found:
            group = line if line[:1].isalpha() else group
        elif found.group(1) in WRITTEN_ALL_THE_SAME or group not in GROUPS_THAT_WRITE:
            flags.add(found.group(1))
    return flags - set(NOT_IN_A_LIST)


def rows_of(recordings, known_flags):
    """The rows of --recordings: a folder of recordings, or a list of them."""
    path = pathlib.Path(recordings)
    if path.is_dir():
        return rows_of_folder(path)
    if not path.exists():
        raise Fault(f"{recordings}: cannot open: No such file or directory")
    return rows_of_list(path, known_flags)


def is_recording(path):
    """Whether a folder's entry may be a recording. What is one and damaged is for the run to say."""
    if path.is_file():
        return path.suffix.lower() in VIDEOS_AND_FILES
    try:
        with os.scandir(path) as entries:
            for entry in entries:
                suffix = pathlib.PurePath(entry.name).suffix.lower()
                if entry.name in MARKS or suffix in IMAGES or suffix in (".db3", ".mcap"):
                    return True
    except OSError:
        return path.is_dir()
    return False


def rows_of_folder(folder):
    names = sorted(os.listdir(folder))
    rows = [Row(name, str(folder.resolve() / name)) for name in names
            if not name.startswith(".") and is_recording(folder / name)]
    others = sum(not name.startswith(".") for name in names) - len(rows)
    if others:
        print(f"tagtwist_fleet: {folder}: passed over {others} entries that are no recordings", file=sys.stderr)
    if not rows:
        raise Fault(f"{folder}: holds no recording: expected videos, bags, .mat files or folders of recordings")
    return rows


def values_of(cell):
    r"""The values of a cell: 'a | b' are two; '\|' is a bar that parts nothing."""
    parts = re.split(r"(?<!\\)\|", cell)
    return [part.replace("\\|", "|").strip() for part in parts]


def check_columns(path, columns, known_flags):
    for column in columns:
        if columns.count(column) > 1:
            raise Fault(f"{path}:1: column '{column}' is there twice")
        if column in OWN_COLUMNS or column in known_flags:
            continue
        near = difflib.get_close_matches(column, sorted(known_flags) + list(OWN_COLUMNS), 1)
        hint = f", did you mean {near[0]}?" if near else ""
        raise Fault(f"{path}:1: column '{column}': expected recording, name, pieces, or a flag of "
                    f"tagtwist_estimate that says what to read or how{hint}")
    if "recording" not in columns:
        raise Fault(f"{path}:1: expected a column 'recording'")


def read_table(path):
    """Column names, and (line, cells) of each row that is not empty."""
    try:
        with open(path, newline="", encoding="utf-8-sig", errors="surrogateescape") as file:
            reader = csv.reader(file, strict=True)
            columns = [name.strip() for name in next(reader, [])]
            rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except (OSError, csv.Error) as error:
        raise Fault(f"{path}: cannot read: {getattr(error, 'strerror', None) or error}") from error
    if not rows:
        raise Fault(f"{path}: no rows")
    for line, cells in rows:
        if len(cells) != len(columns):
            raise Fault(f"{path}:{line}: expected {len(columns)} columns, got {len(cells)}")
    return columns, rows


def combinations(columns, cells):
    """Every choice of one value from each cell, as {column: value}."""
    choices = [values_of(cell) if column not in ("recording", "name") else [cell.strip()]
               for column, cell in zip(columns, cells)]
    return [dict(zip(columns, choice)) for choice in itertools.product(*choices)]


def make_row(path, line, values, swept_columns):
    recording = values.pop("recording")
    if not recording:
        raise Fault(f"{path}:{line}: recording: expected a path, got nothing")
    name = values.pop("name", "") or recording
    pieces = values.pop("pieces", "") or "1"
    if not re.fullmatch(r"[1-9][0-9]{0,2}", pieces):
        raise Fault(f"{path}:{line}: pieces: expected 1 to 999, got '{pieces}'")
    flags = {column: value for column, value in values.items() if value}
    for column in PATHS:
        if column in flags:
            flags[column] = str(path.parent.resolve() / flags[column])
    swept = {column: values[column] for column in swept_columns if column in values}
    return Row(name, str(path.parent.resolve() / recording), flags, swept, int(pieces))


def rows_of_list(path, known_flags):
    columns, table = read_table(path)
    check_columns(path, columns, known_flags)
    swept = [column for i, column in enumerate(columns) if column not in OWN_COLUMNS
             and any(len(values_of(cells[i])) > 1 for _, cells in table)]
    rows, lines = [], {}
    for line, cells in table:
        for values in combinations(columns, cells):
            row = make_row(path, line, values, swept)
            if row.id in lines:
                raise Fault(f"{path}:{line}: '{row.name}' is listed twice, first in line {lines[row.id]}: "
                            "give one of them another name (column 'name')")
            lines[row.id] = line
            rows.append(row)
    return rows
