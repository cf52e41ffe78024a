"""Shows on standard error how many bags are done."""
import sys
import time

TERMINAL_PERIOD_S, PLAIN_PERIOD_S = 0.5, 10.0


def _time_text(seconds):
    minutes, seconds = divmod(int(seconds + .5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}"


class Progress:
    """Estimates the time left by bytes, because bags differ in length. Bags that were evaluated
    before do not count."""

    def __init__(self, bags, total_bytes, clock=time.monotonic, out=sys.stderr):
        self.bags, self.bytes_left, self.clock, self.out = bags, total_bytes, clock, out
        self.done = self.there = self.cycles = self.bytes_done = 0
        self.started = clock()
        self.on_terminal = out.isatty()
        self.next_s = self.started + (TERMINAL_PERIOD_S if self.on_terminal else 2)

    def add(self, size, cycles, was_there):
        self.done += 1
        self.bytes_left -= size
        self.there += was_there
        if not was_there:
            self.cycles += cycles
            self.bytes_done += size

    def text(self, places):
        elapsed = max(self.clock() - self.started, 1e-3)
        text = f"{self.done} of {self.bags} bags"
        if self.there:
            text += f" ({self.there} were there)"
        text += f", {self.cycles} cycles, {self.cycles / elapsed:.0f} a second"
        if self.bytes_done:
            left = elapsed * self.bytes_left / self.bytes_done
            text += f", {_time_text(left)} left"
        return text + (", no worker" if places == 0 else "")

    def show(self, places):
        if self.clock() < self.next_s:
            return
        self.next_s = self.clock() + (TERMINAL_PERIOD_S if self.on_terminal else PLAIN_PERIOD_S)
        text = self.text(places)
        self.out.write(f"\r{text}\x1b[K" if self.on_terminal else text + "\n")
        self.out.flush()

    def clear(self):
        if self.on_terminal:
            self.out.write("\r\x1b[K")
