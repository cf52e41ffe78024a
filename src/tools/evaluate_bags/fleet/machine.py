"""What this machine has for local workers, and how they share it."""
import itertools
import os
import re
import subprocess

import yaml

NO_DEVICE = ("", "-1")  # of CUDA_VISIBLE_DEVICES: it and what follows


def gpu_names():
    """Words for CUDA_VISIBLE_DEVICES, each for one GPU; of those that it names already, if any."""
    try:
        listed = subprocess.run(["nvidia-smi", "-L"], stdout=subprocess.PIPE, timeout=30,
                                stderr=subprocess.DEVNULL, universal_newlines=True, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return []
    # By number, nvidia-smi and CUDA may mean different ones.
    names = re.findall(r"^GPU \d+: .*\(UUID: (GPU-[^)]+)\)", listed.stdout, re.MULTILINE)
    given = os.environ.get("CUDA_VISIBLE_DEVICES")
    if names and given is not None:
        words = [word.strip() for word in given.split(",")]
        return list(itertools.takewhile(lambda word: word not in NO_DEVICE, words))
    return names


def core_count():
    return len(os.sched_getaffinity(0))


def worker_count(asked, jobs, gpus):
    """`asked`: None for as many as GPUs, else cores; no more than there are jobs."""
    return max(min(asked or gpus or core_count(), jobs), 1)


def _configured_threads(path):
    """What cannot be read is evaluate_bag's to refuse."""
    try:
        with open(path, errors="replace") as file:
            return yaml.safe_load(file).get("threads", 0)
    except (OSError, AttributeError, yaml.YAMLError):
        return 0


def threads_each(workers, config):
    """Of each worker's evaluate_bag, so that together they have all cores; None: as the file
    `config` (or None) says."""
    if config and _configured_threads(config) != 0:
        return None
    return max(core_count() // workers, 1)
