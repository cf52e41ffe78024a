"""What each local worker has of this machine: GPUs and cores."""
import os
import subprocess

CORES = "EVALUATE_BAGS_CORES"  # numbers of cores, of a worker's environment


def gpu_count():
    try:
        listed = subprocess.run(["nvidia-smi", "-L"], stdout=subprocess.PIPE, timeout=30,
                                stderr=subprocess.DEVNULL, universal_newlines=True, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return 0
    return sum(line.startswith("GPU ") for line in listed.stdout.splitlines())


def environments(count, gpus, cores):
    """For each of `count` workers: one of the GPUs, if there are any, and its share of the cores,
    so that their threads do not take turns; at least one."""
    found = []
    for i in range(count):
        mine = cores[i::count] or [cores[i % len(cores)]]
        found.append({CORES: ",".join(str(core) for core in mine)})
        if gpus:
            found[i]["CUDA_VISIBLE_DEVICES"] = str(i % gpus)
    return found


def keep_to_cores():
    """This process, and those that it starts. Workers that others started have all cores."""
    if CORES in os.environ:
        os.sched_setaffinity(0, [int(core) for core in os.environ[CORES].split(",")])
