#!/usr/bin/python3
"""Evaluates one bag on a worker of evaluate_bags: fleet_job.py JOB, in JSON. Writes the record of
the result to standard output. Any exit code but 0 means that the attempt has no result."""
import json
import os
import sys

from fleet.evaluation import Crashed, Evaluation, Stopped


def main():
    job = json.loads(sys.argv[1])
    try:
        os.chdir(job["folder"])
        os.environ.update(job["environment"])
        print(json.dumps(Evaluation(job).run()))
    except (Crashed, Stopped) as error:
        sys.exit(f"fleet_job.py: {error}")
    except OSError as error:
        # That of a full disk names no file; what a job writes is below this folder.
        where = "" if error.filename else job["out"] + ": "
        sys.exit(f"fleet_job.py: {where}{error}")


if __name__ == "__main__":
    main()
