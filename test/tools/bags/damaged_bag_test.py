#!/usr/bin/env python3
"""evaluate_bag on damaged bags: cut off, and with bytes changed anywhere. It never crashes or
hangs, says in one line what is wrong, and keeps what came before. DCM_FUZZ_BAGS is how many of each
kind."""
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import tempfile
import unittest

import rosbag

from panda_bag import DATA, FRAMES, PandaBag, write_bag

TOOL = os.environ["EVALUATE_BAG"]
COUNT = int(os.environ.get("DCM_FUZZ_BAGS", "40"))
PATIENCE_S = 100  # a reader that hangs is given up after 60
CONFIG = "reference_frame: panda_link0\nobjects: [{name: tshirt, topic: /tshirt}]\n"


class DamagedBags(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.config = os.path.join(cls.folder, "config.yaml")
        pathlib.Path(cls.config).write_text(CONFIG)
        scene = PandaBag()
        cls.bags = {}
        for compression in "none", "bz2", "lz4":
            path = write_bag(os.path.join(cls.folder, compression + ".bag"), scene.events(),
                             compression=compression, chunk=65536)
            cls.bags[compression] = pathlib.Path(path).read_bytes()

    def evaluate(self, content):
        """(exit code, last line on standard error, summary or None)."""
        bag = os.path.join(self.folder, "damaged.bag")
        pathlib.Path(bag).write_bytes(content)
        out = os.path.join(self.folder, "out")
        shutil.rmtree(out, ignore_errors=True)
        done = subprocess.run([TOOL, bag, "--config", self.config, "--out", out, "--no-report"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=PATIENCE_S,
                              check=False)
        self.assertIn(done.returncode, (0, 2), done)
        error = done.stderr.decode(errors="replace").splitlines()
        for line in error:  # names in a damaged bag may hold anything
            self.assertRegex(line, r"^evaluate_bag: |\(\d+ s\)$")  # the latter: progress
        self.assertTrue(done.returncode == 0 or error, done)
        summary = None
        if os.path.exists(out + "/summary.json"):
            with open(out + "/summary.json") as file:
                summary = json.load(file)
        return done.returncode, error[-1] if error else "", summary

    def test_whole(self):
        for content in self.bags.values():
            code, _, summary = self.evaluate(content)
            self.assertEqual((code, summary["cycles"]), (0, FRAMES))

    def test_cut_off_anywhere(self):
        source = random.Random(1)
        for i in range(COUNT):
            content = self.bags[("none", "bz2", "lz4")[i % 3]]
            size = source.randrange(len(content))
            code, error, _ = self.evaluate(content[:size])
            self.assertEqual(code, 2, f"cut to {size} bytes")
            self.assertRegex(error, "is empty|is no bag|rosbag reindex")

    def places(self, content):
        """Where the index, the chunks' contents and the records' headers are."""
        path = os.path.join(self.folder, "whole.bag")
        pathlib.Path(path).write_bytes(content)
        with rosbag.Bag(path) as bag:
            chunks = [chunk.pos for chunk in bag._chunks]
            index = bag._index_data_pos
        headers = [chunk + offset for chunk in chunks for offset in range(80)] + list(range(13, 90))
        return {"index": list(range(index, len(content))), "headers": headers,
                "chunks": list(range(chunks[0], index))}

    def test_bytes_changed(self):
        source = random.Random(2)
        outcomes = {}
        for compression, content in self.bags.items():
            places = self.places(content)
            for i in range(COUNT):
                where = ("index", "headers", "chunks")[i % 3]
                damaged = bytearray(content)
                for _ in range(source.choice((1, 1, 4, 64))):
                    damaged[source.choice(places[where])] = source.randrange(256)
                code, error, summary = self.evaluate(bytes(damaged))
                outcomes.setdefault((where, code), []).append(error)
                if code == 2 and summary is not None:
                    self.assertIn("what could be read is in", error)
                    self.assertFalse(summary["passed"])
                if code == 0:  # whatever was changed, no message was lost by it
                    self.assertEqual(summary["cycles"], FRAMES)
        # Not all of it may go unnoticed, or this test looks at nothing.
        for where in "index", "headers":
            self.assertGreater(len(outcomes.get((where, 2), [])), COUNT / 10, where)

    def test_a_lower_count_in_an_index_is_no_silent_loss(self):
        content = self.bags["none"]
        changed = 0
        for field in re.finditer(rb"count=(.{4})", content, re.DOTALL):
            count = int.from_bytes(field.group(1), "little")
            if not 2 <= count < 1000:
                continue
            lower = (count - 1).to_bytes(4, "little")
            changed_content = content[:field.start(1)] + lower + content[field.end(1):]
            code, error, _ = self.evaluate(changed_content)
            self.assertEqual(code, 2)
            self.assertIn("rosbag reindex", error)
            changed += 1
        self.assertGreater(changed, 5)

    def test_without_the_mesh_the_damage_is_named(self):
        content = bytearray(self.bags["bz2"])
        first = content.index(b"BZh")
        content[first + 40:first + 400] = bytes(360)
        code, error, _ = self.evaluate(bytes(content))
        self.assertEqual(code, 2)
        self.assertIn("damaged: ", error)

    def test_what_came_before_the_damage_is_kept(self):
        """The last chunks are destroyed: messages in them are lost, those before are not."""
        for compression in "bz2", "lz4":
            content = bytearray(self.bags[compression])
            path = os.path.join(self.folder, "whole.bag")
            pathlib.Path(path).write_bytes(content)
            with rosbag.Bag(path) as bag:
                chunks = [chunk.pos for chunk in bag._chunks]
            middle = chunks[2 * len(chunks) // 3]
            for i in range(middle + 200, middle + 400):
                content[i] ^= 0x5A
            code, error, summary = self.evaluate(bytes(content))
            self.assertEqual(code, 2)
            self.assertIn("what could be read is in", error)
            self.assertGreater(summary["cycles"], FRAMES / 3)
            self.assertLess(summary["cycles"], FRAMES)
            self.assertNotEqual(summary["problem"] + str(summary["damaged_messages"]), "0")


if __name__ == "__main__":
    if not DATA.is_dir():
        print(f"SKIPPED: there are no test data at {DATA}")
        raise SystemExit(77)
    unittest.main()
