#!/usr/bin/python3
"""Tells Snakemake how a Slurm job is: running, success or failed. Without accounting: Slurm forgets a job some
minutes after its end (MinJobAge); one that it does not know any more is failed, and so is tried again."""
import re
import subprocess
import sys
import time

RUNNING = {"PENDING", "CONFIGURING", "RUNNING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING", "STAGE_OUT",
           "REQUEUE_HOLD", "REQUEUE_FED", "SPECIAL_EXIT", "STOPPED", "SIGNALING"}
ATTEMPTS = 4


def state_of(job):
    """The job's state; '' where Slurm does not know it; None where Slurm does not answer."""
    told = subprocess.run(["scontrol", "--oneliner", "show", "job", job], capture_output=True, text=True,
                          check=False)
    found = re.search(r"JobState=([A-Z_]+)", told.stdout)
    if found:
        return found.group(1)
    return "" if "Invalid job id" in told.stderr else None


def main():
    for attempt in range(ATTEMPTS):
        state = state_of(sys.argv[1])
        if state is not None:
            break
        time.sleep(2 ** attempt)
    if state is None or state in RUNNING:  # a controller that restarts says nothing of the job
        print("running")
    else:
        print("success" if state == "COMPLETED" else "failed")


if __name__ == "__main__":
    main()
