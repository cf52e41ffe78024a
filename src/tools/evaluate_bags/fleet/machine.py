"""Finds the GPUs and cores of this machine, and shares them among local workers."""
import itertools
import os
import re
import subprocess

import yaml

NO_DEVICE = ("", "-1")  # ends the list in CUDA_VISIBLE_DEVICES


def gpu_names():
    """Returns words for CUDA_VISIBLE_DEVICES, each for one GPU. If the variable is set, only the
    GPUs that it names count."""
    try:
        listed = subprocess.run(["nvidia-smi", "-L"], stdout=subprocess.PIPE, timeout=30,
                                stderr=subprocess.DEVNULL, universal_newlines=True, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return []
    # Numbers of GPUs may differ between nvidia-smi and CUDA, so UUIDs are used.
    names = re.findall(r"^GPU \d+: .*\(UUID: (GPU-[^)]+)\)", listed.stdout, re.MULTILINE)
    given = os.environ.get("CUDA_VISIBLE_DEVICES")
    if names and given is not None:
        words = [word.strip() for word in given.split(",")]
        return list(itertools.takewhile(lambda word: word not in NO_DEVICE, words))
    return names


def core_count():
    return len(os.sched_getaffinity(0))


def worker_count(asked, jobs, gpus):
    """Returns the number of workers: as asked, or one for each GPU, or one for each core; at most
    one for each job."""
    return max(min(asked or gpus or core_count(), jobs), 1)


def _configured_threads(path):
    """Returns the configuration's `threads`. evaluate_bag reports a file that cannot be read."""
    try:
        with open(path, errors="replace") as file:
            return yaml.safe_load(file).get("threads", 0)
    except (OSError, AttributeError, yaml.YAMLError):
        return 0


def threads_each(workers, config):
    """Returns the threads of each evaluate_bag, so that all together use all cores. None if the
    configuration file says how many."""
    if config and _configured_threads(config) != 0:
        return None
    return max(core_count() // workers, 1)
