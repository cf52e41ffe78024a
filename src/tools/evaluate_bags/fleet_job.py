#!/usr/bin/python3
"""What a worker of evaluate_bags runs for each bag: fleet_job.py JOB, in JSON. The record of the
result goes to standard output; any exit code but 0 is an attempt that came to nothing."""
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
    except (Crashed, Stopped, OSError) as error:
        sys.exit(f"fleet_job.py: {error}")


if __name__ == "__main__":
    main()
