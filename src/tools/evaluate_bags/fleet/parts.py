"""Long bags in parts: first a job that looks whether the result is there, then a job for the
contacts of each part, then one that joins them."""
import math

import rosbag

MOST_PARTS = 1000


def minutes_of(path):
    """Of recording; 0 of what is no whole bag, which evaluate_bag refuses by its own words."""
    try:
        with rosbag.Bag(path, skip_index=True) as bag:
            return max((bag.get_end_time() - bag.get_start_time()) / 60, 0)
    except Exception:  # pylint: disable=broad-except  # rosbag's are of any type at such a file
        return 0


def count_of(path, minutes):
    """How many parts a bag takes that is split into such of `minutes`; 0: never."""
    if minutes == 0:
        return 1
    return min(max(math.ceil(minutes_of(path) / minutes), 1), MOST_PARTS)


class Splits:
    """Which jobs come after a job. What cannot be had in parts is evaluated in one."""

    def __init__(self, make_job, progress):
        """`make_job(name, bag, **fields)`: a job with more fields."""
        self.make_job, self.progress = make_job, progress
        self.waiting = {}  # name: jobs of its parts that have not ended

    def first(self, name, bag, parts):
        return self.make_job(name, bag, parts=parts)

    def after(self, job, record):
        """Jobs that come next; None: `record` (None: the job failed) is the bag's own."""
        name, fields = job["name"], job["fields"]
        if "part" in fields:
            return self._after_part(job, record)
        if record is None or "split" not in record:
            return None
        jobs = [self.make_job(name, job["bag"], parts=fields["parts"], part=number + 1,
                              identity=record["split"]) for number in range(fields["parts"])]
        self.waiting[name] = list(jobs)
        self.progress.parts += len(jobs)
        return jobs

    def _after_part(self, job, record):
        self.progress.parts_done += 1
        name, fields = job["name"], job["fields"]
        if name not in self.waiting:
            return []
        self.waiting[name].remove(job)
        is_there = record is not None and "refused" not in record
        if is_there and self.waiting[name]:
            return []
        for other in self.waiting.pop(name):
            other["given_up"] = True
        return [self.make_job(name, job["bag"], parts=fields["parts"] if is_there else 1,
                              identity=fields["identity"])]
