#!/usr/bin/env python3
"""measure_trade --states as its users see it: table, summary, plot and messages. The tool is
$MEASURE_TRADE."""
import os
import unittest

from trade_case import Case, cloth

URDF = """<robot name="arm"><link name="base"/>
<link name="{0}"><collision><origin xyz="0.25 0 0"/>
  <geometry><box size="0.5 0.05 0.05"/></geometry></collision></link>
<joint name="turn" type="{1}"><parent link="base"/><child link="{0}"/>
  <origin xyz="0.5 0.5 0.5"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
</joint></robot>"""


class States(Case):
    """An arm that turns about a place over a cloth, and dips into it in some states."""

    def scene(self, link="arm", joint="revolute"):
        return ["--urdf", self.mesh("arm.urdf", URDF.format(link, joint)),
                self.mesh("cloth.obj", cloth(0.2))]

    def test_table(self):
        if "a build without ROS" in self.run_tool("--states", "1", *self.scene()).stderr:
            self.skipTest("a build without ROS reads no robots")
        done = self.works("--states", "200", "--repeats", "2", *self.scene(), plots=True)
        rows = self.table("states.csv")
        ours = [(row["question"], row["batch"]) for row in rows if row["way"] == "cpu"]
        self.assertEqual(ours, [(question, batch) for question in ("touch", "nearest")
                                for batch in ("1", "10", "100", "200")])
        for row in rows:
            self.assertTrue(0 < float(row["median_us"]) <= float(row["p95_us"]), row)
            self.assertEqual((row["states"], row["threads"]), ("200", "1"))
            if row["way"] == "cpu":
                self.assertEqual((row["false_free"], row["false_blocked"]), ("0", "0"))
            if row["way"].startswith("spheres_covering"):
                self.assertEqual(row["false_free"], "0")
                self.assertGreaterEqual(float(row["false_blocked"]), 0)
        summary = self.summary()
        self.assertEqual((summary["states"], [body["name"] for body in summary["bodies"]]),
                         (200, ["mesh", "arm"]))
        self.assertTrue(20 < summary["touching"] < 180, summary["touching"])
        self.assertEqual(len(summary["ways"]), len(rows))
        self.assertRegex(done.stdout, r"\A  cpu +touch +1 threads, +1 states a batch: median")
        self.assertGreater(os.path.getsize(self.path("trade", "states.png")), 5000)

    def test_refuses(self):
        scene = self.scene()
        self.assert_refused(["--states", "5", scene[-1]], "--states", "--urdf")
        self.assert_refused(scene, "--urdf", "--states")
        self.assert_refused(["--states", "5", *scene, scene[-1]], "--states takes one mesh file")
        self.assert_refused(["--states", "-1", *scene], "--states")
        for other in (["--swept"], ["--margins"], ["--self"], ["--cycles", "3"]):
            self.assert_refused(["--states", "5", *other, *scene], "--states", other[0])
        self.assert_refused(["--states", "5", *self.scene(joint="fixed")])
        self.assert_refused(["--states", "5", "--urdf", self.path("none.urdf"), scene[-1]])


if __name__ == "__main__":
    unittest.main()
