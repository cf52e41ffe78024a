#!/usr/bin/env python3
"""evaluate_bags against an earlier run: one changed mesh is found, and what may change."""
import os
import shutil

import numpy

from fleet_case import DATA, FleetCase, main

CHANGED = "panda_hand"


class Baseline(FleetCase):

    def setUp(self):
        super().setUp()
        without = [event for event in self.events if event[1] != "/contact_monitor/robot_meshes"]
        self.bag("bags/one.bag", without)
        self.bag("bags/two.bag", without, compression="bz2")
        self.robots = self.path("robots")
        shutil.copytree(str(DATA / "robots/panda_description"), self.robots + "/panda_description",
                        ignore=shutil.ignore_patterns("visual"))

    def shrink_hand(self):
        path = self.robots + "/panda_description/meshes/collision/hand.stl"
        with open(path, "rb") as file:
            head, body = file.read(84), file.read()
        triangles = numpy.frombuffer(body, numpy.dtype([("normal", "<3f4"), ("corners", "<9f4"),
                                                        ("attribute", "<u2")])).copy()
        triangles["corners"] *= .7
        with open(path, "wb") as file:
            file.write(head + triangles.tobytes())

    def run_it(self, out, *more, code):
        return self.run_fleet(out, "--no-report", *more, code=code, robots=self.robots)

    def rules(self, text):
        return "--allow", self.text("allow.yaml", text)

    @staticmethod
    def kinds(bag):
        return {change["kind"] for change in bag["changes"] if change["kind"] != "latency"}

    def test_one_changed_mesh(self):
        self.run_it("first", code=0)
        same = self.run_it("same", "--baseline", self.path("first"), code=0)
        self.assertEqual([self.kinds(bag) for bag in same["bags"]], [set(), set()])

        self.shrink_hand()
        fleet = self.run_it("second", "--baseline", self.path("first"), code=1)
        for bag in fleet["bags"]:
            of_bodies = [c for c in bag["changes"] if c["bodies"]]
            self.assertEqual({tuple(c["bodies"]) for c in of_bodies}, {(CHANGED, "tshirt")})
            self.assertIn("moved", self.kinds(bag))
            self.assertFalse(any(c["allowed"] for c in of_bodies))
        with open(self.path("second/index.html")) as file:
            self.assertIn("NOT ALLOWED", file.read())

        again = self.run_it("same", code=0)
        self.assertEqual(again["were_there"], 0, "a mesh is another")
        self.may_change(self.kinds(fleet["bags"][0]))

    def may_change(self, kinds):
        rules = [f"- {{change: {kind}, link: panda_h*}}\n" for kind in sorted(kinds)]
        baseline = "--baseline", self.path("first")
        self.run_it("second", *baseline, *self.rules("".join(rules)), code=0)
        self.run_it("second", *baseline, *self.rules("".join(rules[1:])), code=1)
        self.run_it("second", *baseline,
                    *self.rules("".join(rules) + "- {change: latency, ratio: 0}\n"), code=1)
        one = "".join(rules).replace("link: panda_h*", "bag: one.bag")
        fleet = self.run_it("second", *baseline, *self.rules(one), code=1)
        by_bag = {bag["bag"]: {c["allowed"] for c in bag["changes"] if c["bodies"]}
                  for bag in fleet["bags"]}
        self.assertEqual(by_bag, {"one.bag": {True}, "two.bag": {False}})
        os.remove(self.path("bags/two.bag"))
        fleet = self.run_it("second", *baseline, *self.rules("".join(rules)), code=1)
        self.assertEqual([c["bag"] for c in fleet["bags_gone"]], ["two.bag"])


if __name__ == "__main__":
    main()
