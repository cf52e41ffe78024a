"""Reads memory and processor time of a running process from /proc."""
import os
import statistics
import time

TICKS_S = os.sysconf("SC_CLK_TCK")


class ProcessFigures:
    """Samples; look() once a second."""

    def __init__(self, pid):
        self.pid = pid
        self.memory_mib = []
        self.started = time.monotonic()
        self.cpu_before_s = self.cpu_s()

    def cpu_s(self):
        with open(f"/proc/{self.pid}/stat") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / TICKS_S

    def look(self):
        with open(f"/proc/{self.pid}/status") as status:
            line = next((line for line in status if line.startswith("VmRSS:")), None)
        if line is not None:  # else it is ending
            self.memory_mib.append(int(line.split()[1]) / 1024)

    def cpu_share(self):
        """Of one core, since the beginning."""
        return (self.cpu_s() - self.cpu_before_s) / (time.monotonic() - self.started)

    def memory(self):
        """[MiB]: median of the first and of the last tenth, and the most."""
        tenth = max(1, len(self.memory_mib) // 10)
        return {"start": statistics.median(self.memory_mib[:tenth]),
                "end": statistics.median(self.memory_mib[-tenth:]), "most": max(self.memory_mib)}


def has_grown(memory):
    """Whether a process takes more at the end than what noise and caches explain."""
    return memory["end"] > 1.1 * memory["start"] + 20
