"""What the pages of config/docs tell a reader to save and to type, and terminals to type it in."""
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PAGES = SOURCE / "config" / "docs"
WAIT_S = 400  # of wall time; far longer than anything takes, also on a busy machine
RELUCTANT_S = 30  # the same, for a program that was told to end
FENCE = re.compile(r"```(\w+)\n(.*?)```", re.S)
USUAL_NAMES = {"python": "publisher.py", "yaml": "monitor.yaml"}  # config/docs/mesh_from/README.md


class Page:

    def __init__(self, path):
        self.path = PAGES / path
        self.text = self.path.read_text()

    def files(self):
        """{name: text} of the blocks that a reader saves. The paragraph before a block names it."""
        files = {}
        for fence in FENCE.finditer(self.text):
            paragraph = self.text[:fence.start()].rstrip().rsplit("\n\n", 1)[-1]
            names = re.findall(r"as\s`([\w.]+)`", paragraph)
            files[names[-1] if names else USUAL_NAMES.get(fence.group(1))] = fence.group(2)
        files.pop(None, None)
        return files

    def commands(self):
        """The lines that a reader types, in the order of the page."""
        indented = re.findall(r"(?:^    .*\n)+", FENCE.sub("", self.text), re.M)
        return [line.strip() for block in indented
                for line in re.sub(r" \\\n +", " ", block).splitlines()]


class Terminal:
    """A line that runs in a shell, and what it has printed. Its programs end with SIGINT."""

    def __init__(self, line, **options):
        self.line = line
        self._log = tempfile.TemporaryFile("w+", errors="replace")
        self._process = subprocess.Popen(["bash", "-c", line], start_new_session=True,
                                         stdout=self._log, stderr=subprocess.STDOUT, **options)

    def text(self):
        self._log.seek(0)
        return self._log.read()

    def wait(self, pattern):
        """Returns the match in what was printed; waits for it if need be."""
        deadline = time.monotonic() + WAIT_S
        while True:
            ended = self._process.poll() is not None
            match = re.search(pattern, self.text())
            if match:
                return match
            if ended or time.monotonic() > deadline:
                raise AssertionError(f"{self.line}: no {pattern!r} in\n{self.text()}")
            time.sleep(0.05)

    def end(self):
        """Waits for the program's own end. Returns its exit code and what it has printed."""
        self._process.wait(WAIT_S)
        return self._process.returncode, self.text()

    def stop(self):
        if self._log.closed:
            return
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGINT)
        # rospy's handler of SIGINT closes the connections, and takes their locks for it. If SIGINT
        # comes while the main thread publishes, it waits for a lock that it holds (QueuedConnection
        # in tcpros_pubsub.py), for ever.
        if "python3" in self.line:
            try:
                self._process.wait(RELUCTANT_S)
            except subprocess.TimeoutExpired:
                print("rospy hangs, and is killed")
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait(WAIT_S)
        print(f"$ {self.line}\n{self.text()}")  # ctest shows it if the test fails
        self._log.close()


class PageCase(unittest.TestCase):
    """Runs what pages say. All that it starts ends with the test."""

    def folder_of(self, page):
        """Makes a folder with the files that a reader saves."""
        folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, str(folder))
        for name, text in page.files().items():
            (folder / name).write_text(text)
        return folder

    def terminal(self, line, folder, **variables):
        terminal = Terminal(line, cwd=str(folder), env={**os.environ, **variables})
        self.addCleanup(terminal.stop)
        return terminal


def free_port():
    """A port for a master that starts later. It is none of those that Linux gives to sockets that
    ask for any, since another process may be given one of those until then."""
    while True:
        port = random.randrange(11400, 32768)
        with socket.socket() as one:
            if one.connect_ex(("127.0.0.1", port)) != 0:
                return port
