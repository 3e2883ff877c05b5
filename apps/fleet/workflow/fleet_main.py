"""The command line of tagtwist_fleet."""
import argparse
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys

import fleet_engine
from fleet_fault import Fault
from fleet_list import flags_of, rows_of
from fleet_plan import (check_places, chunks_of, digest_of, is_done, job_of, read_json, remove_parts, to_json, why,
                        write_whole)

SUMMARY = """Estimates many recordings with tagtwist_estimate, on this machine or on a cluster, and gathers
the results in one table: fleet.html, fleet.csv, fleet.json in --output. What is done is not done
again; a recording that fails stops no other."""


class OneLine(argparse.ArgumentParser):
    """Wrong usage is told in one line."""

    def error(self, message):
        raise Fault(message, 2)


def count(least, most):
    def parse(text):
        if not text.isdigit() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"expected {least} to {most}, got '{text}'")
        return int(text)
    return parse


def make_parser():
    parser = OneLine(prog="tagtwist_fleet", description=SUMMARY, allow_abbrev=False,
                     formatter_class=argparse.RawDescriptionHelpFormatter,
                     usage="tagtwist_fleet --recordings DIR|LIST.csv --output DIR [options] [-- FLAGS]",
                     epilog="After -- come flags of tagtwist_estimate for every recording: -- --use_detections")
    add = parser.add_argument
    add("--recordings", required=True, metavar="DIR|LIST.csv",
        help="a folder of recordings, or a list: recording, and flags of tagtwist_estimate as columns; "
             "'a | b' in a cell runs both")
    add("--output", required=True, metavar="DIR", help="a folder of its own")
    add("--config", default="", metavar="FILE", help="configuration of the recordings that name none")
    add("--jobs", type=count(1, 100000), default=os.cpu_count() or 1, metavar="N",
        help="runs at once, of a thread each; on a cluster, jobs at once [the machine's cores]")
    add("--profile", default="local", metavar="NAME|DIR",
        help="local, slurm, or a folder with a profile of Snakemake [local]")
    add("--group", type=count(0, 100000), default=0, metavar="N",
        help="recordings a job of the engine; 0: one here as long as they are few, 20 on a cluster [0]")
    add("--pieces", type=count(1, 999), default=1, metavar="N",
        help="each recording's images are searched in N jobs, unless the list says otherwise [1]")
    add("--retries", type=count(0, 100), default=2, metavar="N", help="attempts more for a job that was killed [2]")
    add("--mem_mb", type=count(1, 10 ** 7), default=2000, metavar="N", help="memory of a job on a cluster [2000]")
    add("--minutes", type=count(1, 10 ** 6), default=30, metavar="N",
        help="time of a recording on a cluster [30]; both grow with each attempt")
    add("--again_failed", action="store_true", help="also those that failed before")
    add("--against", default="", metavar="OLD", help="an older fleet's --output, or its fleet.json: what changed")
    add("--dry_run", action="store_true", help="tells what would be run, and writes nothing")
    add("--version", action="store_true", help="prints the version")
    return parser


def told_by(program, *flags):
    try:
        return subprocess.run([str(program), *flags], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        raise Fault(f"{program}: cannot run: {getattr(error, 'strerror', None) or error}") from error


def common_flags(extra, known):
    """Flags behind --, for every recording."""
    out = {}
    for text in extra:
        name, given, value = text.lstrip("-").partition("=")
        negated = not given and name.startswith("no") and name not in known
        name = name[2:] if negated else name
        if not text.startswith("-") or name not in known:
            raise Fault(f"'{text}' behind --: expected a flag of tagtwist_estimate as --name=value", 2)
        out[name] = value if given else ("false" if negated else "true")
    return out


def take_rows(options, extra, programs):
    estimate = programs / "tagtwist_estimate"
    told_by(estimate, "--version")
    known = flags_of(estimate)
    rows = rows_of(options.recordings, known)
    common = common_flags(extra, known)
    if options.config:
        common.setdefault("config", str(pathlib.Path(options.config).resolve()))
        if not pathlib.Path(options.config).is_file():
            raise Fault(f"{options.config}: cannot open: expected a configuration")
    for row in rows:
        row.flags = {**common, **row.flags}
        row.pieces = row.pieces if row.pieces > 1 else options.pieces
        for flag in ("sliding_window", "calibrate", "map_unknown_tags", "use_detections", "from", "to"):
            if row.flags.get(flag, "false") != "false":
                row.pieces = 1  # they have nothing to share
    return rows


def readable(text):
    """A text that JSON can hold: bytes of file names that are no UTF-8 are replaced."""
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def why_not_run(output, row):
    """Of a recording that has no record: a piece of it was ended, or the engine was."""
    for state in sorted((output / "pieces" / row.id).glob("*.json")):
        piece = read_json(state) or {}
        if piece.get("outcome") == "unfinished":
            return f"a piece of it: {piece.get('error', '')}"
    return "was not run: .fleet/snakemake.txt says why"


def outcome_of(output, row, job):
    record = read_json(output / "records" / f"{row.id}.json") or {}
    is_of_this = record.get("job") == digest_of(job)
    return {"name": readable(row.name), "folder": f"runs/{row.id}", "log": f"logs/{row.id}.txt",
            "values": {flag: readable(value) for flag, value in row.swept.items()},
            "outcome": record.get("outcome", "unfinished") if is_of_this else "unfinished",
            "error": readable(record.get("error", "") if is_of_this else why_not_run(output, row)),
            "wall_s": record.get("wall_s", 0) if is_of_this else 0,
            "version": job["version"], "program_sha256": job["program_sha256"]}


def gather(options, output, outcomes, programs):
    """The table, by tagtwist_compare; its exit status."""
    write_whole(output / "runs.json", to_json({"runs": outcomes}))
    command = [str(programs / "tagtwist_compare"), "--collect", f"--output={output}"]
    if options.against:
        command.append(f"--against={options.against}")
    status = subprocess.run([*command, "--", str(output)], check=False).returncode
    if status:
        raise Fault(f"{output}: no table: tagtwist_compare ended with status {status}")


def tell_dry_run(output, rows, jobs, pending):
    for row in pending:
        print(f"{fleet_engine.printable(row.name)}: {why(output, row.id, jobs[row.id])}")
    print(f"{len(pending)} of {len(rows)} recordings would be run")


def group_size(options, pending):
    if options.group:
        return options.group
    if options.profile != "local":
        return 20
    return max(1, len(pending) // (100 * options.jobs))  # the engine is slow with very many jobs


def threads_of(row):
    text = row.flags.get("threads", "1")
    if not text.isdigit():
        raise Fault(f"{row.name}: threads: expected a number, got '{text}'")
    return int(text) or os.cpu_count()


def fleet(options, extra, programs):
    output = pathlib.Path(options.output).resolve()
    rows = take_rows(options, extra, programs)
    check_places(output, rows, options.recordings)
    fleet_engine.profile_folder(options.profile)
    estimate = programs / "tagtwist_estimate"
    version = told_by(estimate, "--version").split()[-1]
    digest = hashlib.sha256(estimate.read_bytes()).hexdigest()
    jobs = {row.id: job_of(row, estimate, version, digest) for row in rows}
    pending = [row for row in rows if not is_done(output, row.id, jobs[row.id], options.again_failed)]
    if options.dry_run:
        tell_dry_run(output, rows, jobs, pending)
        return 0
    if pending:
        fleet_engine.check_installed()
    held = fleet_engine.lock(output)  # noqa: F841: until the end
    remove_parts(output)
    for row in pending:
        place = output / "jobs" / f"{row.id}.json"
        if read_json(place) != jobs[row.id]:
            shutil.rmtree(output / "pieces" / row.id, ignore_errors=True)  # of a job that is no more
        write_whole(place, to_json(jobs[row.id]))
        if options.again_failed:
            (output / "records" / f"{row.id}.json").unlink(missing_ok=True)
    options.threads = max(threads_of(row) for row in rows)
    if pending:
        digests = {row.id: digest_of(jobs[row.id]) for row in pending}
        fleet_engine.run(output, chunks_of(pending, group_size(options, pending)), digests, options)
    outcomes = [outcome_of(output, row, jobs[row.id]) for row in rows]
    gather(options, output, outcomes, programs)
    bad = [o for o in outcomes if o["outcome"] != "done"]
    if bad:
        first = fleet_engine.printable(f"{bad[0]['name']}: {bad[0]['error']}")
        raise Fault(f"{len(bad)} of {len(rows)} recordings failed, the first is {first}; all are in "
                    f"{options.output}/fleet.html")
    return 0


def main(arguments, programs):
    try:
        split = arguments.index("--") if "--" in arguments else len(arguments)
        if "--version" in arguments[:split]:
            print(told_by(programs / "tagtwist_estimate", "--version").replace("tagtwist_estimate", "tagtwist_fleet"))
            return 0
        options = make_parser().parse_args(arguments[:split])
        return fleet(options, arguments[split + 1:], programs)
    except Fault as fault:
        print(f"tagtwist_fleet: {fault}", file=sys.stderr)
        return fault.status
    except KeyboardInterrupt:
        print("tagtwist_fleet: interrupted; the same command goes on from here", file=sys.stderr)
        return 130
    except OSError as error:
        print(f"tagtwist_fleet: {error.filename or ''}: {error.strerror}", file=sys.stderr)
        return 1
