"""What is to be done: a job a row, which says all that its result depends on, and whether it is done."""
import hashlib
import json
import os
import pathlib
import tempfile

try:
    import yaml
except ImportError:  # told where it is needed
    yaml = None

from fleet_fault import Fault

MOST_HASHED_BYTES = 32 << 20
TABLES = (".csv", ".yaml", ".yml", ".json", ".xml", ".txt")


PART = ".part-"  # in the name of a file that is not whole yet


def remove_parts(output):
    """What write_whole left where its process was killed."""
    for folder in (output, output / ".fleet", output / "jobs", output / "records", *output.glob("pieces/*")):
        for left in folder.glob(f".*{PART}*"):
            left.unlink(missing_ok=True)


def write_whole(path, text):
    """Writes a file whole or not at all; nothing is touched where it says the same already."""
    path = pathlib.Path(path)
    data = text.encode("utf-8", "surrogateescape")
    try:
        if path.read_bytes() == data:
            return
    except OSError:
        pass
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, partial = tempfile.mkstemp(prefix=f".{path.name}{PART}", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(partial, 0o666 & ~current_umask())
        os.replace(partial, path)
    except BaseException:
        os.unlink(partial)
        raise


def current_umask():
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def to_json(value):
    return json.dumps(value, indent=1, ensure_ascii=True) + "\n"


def read_json(path):
    """The file's content; None where it is not there, or damaged."""
    try:
        return json.loads(pathlib.Path(path).read_text(encoding="utf-8", errors="surrogateescape"))
    except (OSError, ValueError):
        return None


def identity_of_file(path):
    """The content's digest; of a large file size and time of its last change."""
    status = os.stat(path)
    if status.st_size > MOST_HASHED_BYTES:
        return [status.st_size, status.st_mtime_ns]
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def identity_of(path):
    """What tells this input from a changed one. Of a folder: its tables, and when files came or went: images that
    are written over in place are not seen."""
    path = pathlib.Path(path)
    try:
        if path.is_file():
            return {"": identity_of_file(path)}
        out = {}
        for folder, folders, files in os.walk(path):
            folders.sort()
            inside = os.path.relpath(folder, path)
            if inside.count(os.sep) >= 2:
                folders.clear()
            out[inside + "/"] = os.stat(folder).st_mtime_ns
            for name in sorted(files):
                if name.endswith(TABLES):
                    out[os.path.join(inside, name)] = identity_of_file(os.path.join(folder, name))
        return out
    except OSError as error:
        return {"": error.strerror}


def named_in(config):
    """Files that a configuration names."""
    if yaml is None:
        raise Fault("PyYAML is not installed: apt-get install python3-yaml")
    try:
        tree = yaml.safe_load(pathlib.Path(config).read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError):
        return []
    sections = [tree.get(key) for key in ("camera", "tag_map")] if isinstance(tree, dict) else []
    names = [section.get("file") for section in sections if isinstance(section, dict)]
    return [str(pathlib.Path(config).parent / name) for name in names if isinstance(name, str)]


def inputs_of(row):
    paths = [row.recording]
    for flag in ("config", "camera_file", "map", "ground_truth"):
        if flag in row.flags:
            paths.append(row.flags[flag])
    if "config" in row.flags:
        paths += named_in(row.flags["config"])
    return {path: identity_of(path) for path in paths}


def job_of(row, program, version, program_sha256):
    """All that the row's result depends on."""
    arguments = [f"--dataset={row.recording}"]
    arguments += [f"--{flag}={value}" for flag, value in sorted(row.flags.items())]
    if "threads" not in row.flags:
        arguments.append("--threads=1")
    return {"name": row.name, "program": str(program), "version": version, "program_sha256": program_sha256,
            "arguments": arguments, "flags": row.flags, "swept": row.swept, "pieces": row.pieces,
            "inputs": inputs_of(row)}


def digest_of(job):
    """Where the program lies does not matter, what it is does."""
    known = {key: value for key, value in job.items() if key != "program"}
    return hashlib.sha256(to_json(known).encode()).hexdigest()


def is_done(output, row_id, job, again_failed):
    """Whether the result that is there is that of this job."""
    record = read_json(output / "records" / f"{row_id}.json")
    if not isinstance(record, dict) or record.get("job") != digest_of(job):
        return False
    if record.get("outcome") == "failed":
        return not again_failed
    return record.get("outcome") == "done" and (output / "runs" / row_id / "summary.json").is_file()


def why(output, row_id, job):
    """Why a job is not done, in a word or two."""
    before = read_json(output / "jobs" / f"{row_id}.json")
    if not isinstance(before, dict):
        return "new"
    names = {"program_sha256": "the program", "version": "the program", "arguments": "its flags",
             "inputs": "what it reads", "pieces": "its pieces"}
    changed = [text for key, text in names.items() if before.get(key) != job.get(key)]
    return "changed: " + ", ".join(dict.fromkeys(changed)) if changed else "not finished"


def chunks_of(pending, size):
    """Jobs that go together: `size` recordings each; one that is cut into pieces is alone."""
    out, short = {}, []
    for row in pending:
        if row.pieces > 1:
            out[f"long-{row.id}"] = [row]
        else:
            short.append(row)
    for i in range(0, len(short), size):
        out[f"{i // size:05d}"] = short[i:i + size]
    return out


def check_places(output, rows, recordings):
    """Inputs are never outputs."""
    place = output.resolve()
    if output.exists() and not output.is_dir():
        raise Fault(f"{output}: expected a folder, got a file")
    if place == pathlib.Path(recordings).resolve():
        raise Fault(f"{output}: --output would write among the recordings: choose another place for it")
    for path in {path for row in rows for path in [row.recording]}:
        inside = pathlib.Path(path).resolve()
        if inside == place or inside in place.parents:
            raise Fault(f"{output}: --output lies in the recording {path}: choose another place for it")
    own = [place / name for name in ("fleet.csv", "fleet.json", "fleet.html", "runs.json", "list.csv")]
    if pathlib.Path(recordings).resolve() in own:
        raise Fault(f"{recordings}: --output would overwrite it: choose another place for it")
    if place.is_dir() and any(place.iterdir()) and not (place / ".fleet").is_dir():
        raise Fault(f"{output}: is not empty, and not of a fleet: choose another place for --output")
