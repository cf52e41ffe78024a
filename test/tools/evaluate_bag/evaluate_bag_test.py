#!/usr/bin/env python3
"""evaluate_bag as its users see it: the oracle's pairs, tables, the report, and bad input."""
import importlib.util
import json
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import rospy
from std_msgs.msg import String

from evaluation_case import CONFIG, TOOL, EvaluationCase, main, read_table
from panda_bag import DATA, FRAMES, START, stamp_of
from panda_scene import SHIRT_FRAME
from pose_meshes import write_ply


class EvaluateBag(EvaluationCase):

    def test_other_types_of_messages_have_the_same_pairs(self):
        """The shape is recorded at its stamp, as it has no other."""
        vertices, triangles = self.scene.panda.shirt_mesh(0)
        write_ply(self.path("faces.ply"), (vertices, triangles))
        shapes = [(stamp_of(frame), "/shape", self.scene.shape(frame)) for frame in range(FRAMES)]
        others = [(stamp_of(frame) + rospy.Duration(0, 6000000), topic, message)
                  for frame in range(FRAMES)
                  for topic, message in (("/marker", self.scene.marker(frame)),
                                         ("/array", self.scene.marker_array(frame)),
                                         ("/cells", self.scene.cells_cloud(frame)),
                                         ("/cloud", self.scene.cloud(frame)),
                                         ("/camera", self.scene.cloud(frame)))]
        objects = ["{name: tshirt, topic: /tshirt}",
                   f"{{name: shape, topic: /shape, type: shape_mesh, frame_id: {SHIRT_FRAME}}}",
                   "{name: marker, topic: /marker, type: marker}",
                   "{name: array, topic: /array, type: marker_array, marker: {ns: box, id: 4}}",
                   "{name: cells, topic: /cells, type: tetrahedra, "
                   f"cells: '{self.text('cells.txt', self.scene.cells())}'}}",
                   "{name: cloud, topic: /cloud, type: point_cloud, "
                   f"faces: '{self.path('faces.ply')}'}}"]
        names = ["tshirt", "shape", "marker", "array", "cells", "cloud"]
        if importlib.util.find_spec("pcl_msgs"):
            others += [(stamp_of(frame) + rospy.Duration(0, 6000000), "/polygons",
                        self.scene.polygons(frame)) for frame in range(FRAMES)]
            objects.append("{name: polygons, topic: /polygons, type: polygon_mesh}")
            names.append("polygons")
        config = CONFIG.replace("{name: tshirt, topic: /tshirt}", ", ".join(objects))
        done = self.run_tool("--config", self.text("types.yaml", config), "--pairs",
                             self.bag(events=self.events + shapes + others))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = self.pairs()
        for name in names:
            for frame, pairs in self.expected.items():
                stamp = f"{stamp_of(frame).secs}.{stamp_of(frame).nsecs:09d}"
                with self.subTest(object=name, frame=frame):
                    of_object = {p for p in found.get(stamp, ()) if p[2] == name}
                    each = 4 if name == "cells" else 1
                    self.assertEqual(of_object, {(a, i, name, each * k) for a, i, _, k in pairs})
        with open(self.path("out/summary.json")) as file:
            topics = json.load(file)["topics"]
        self.assertEqual(topics["/cloud"]["messages"], FRAMES)
        self.assertNotIn("/camera", topics, "it is nobody's, and was read")

    def test_images_of_a_depth_camera(self):
        """The shirt's vertices as the pixels of an image, which is a heap of odd triangles."""
        rows, jump = 20, 0.02
        images = [(stamp_of(frame) + rospy.Duration(0, 6000000), "/camera",
                   self.scene.depth_image(frame, rows)) for frame in range(FRAMES)]
        config = CONFIG.replace("{name: tshirt, topic: /tshirt}",
                                "{name: scene, topic: /camera, type: point_cloud, "
                                f"max_depth_jump: {jump}}}")
        done = self.run_tool("--config", self.text("depth.yaml", config), "--pairs",
                             self.bag(events=self.events + images))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found, expected = self.pairs(), self.scene.expected_of_images(rows, jump)
        self.assertTrue(any(expected.values()))
        for frame, pairs in expected.items():
            stamp = f"{stamp_of(frame).secs}.{stamp_of(frame).nsecs:09d}"
            self.assertEqual(set(found.get(stamp, ())), pairs)

    def test_a_rigid_object_is_posed_by_the_bags_transforms(self):
        """It is the copy of a link in that link's frame, so that it has the link's pairs."""
        link = min(pair[0] for pair in self.expected[0])
        write_ply(self.path("tool.ply"), self.scene.panda.links[link])
        tool = (f"{{name: tool, type: rigid, frame: {link}, margin_m: 1, "
                f"mesh: '{self.path('tool.ply')}'}}")
        config = CONFIG.replace("objects: [", f"objects: [{tool}, ")
        done = self.run_tool("--config", self.text("off.yaml", config), "--pairs", self.bag())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("nothing looks at rigid object 'tool'", done.stderr)
        self.assert_oracle_pairs()
        config += "pair_classes: [deformable_rigid]\n"
        expected = self.text("expected.yaml", """
- {link: tool, object: tshirt, touches: sometime}
- {link: tool, object: tshirt, keeps_m: 0.5, from_s: 0.6}
""")
        done = self.run_tool("--config", self.text("on.yaml", config), "--pairs", "--expect",
                             expected, self.bag(), report=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn(f"tool in frame {link}", self.report())
        (rigid,) = self.summary()["configuration"]["rigid_objects"]
        self.assertEqual((rigid["name"], rigid["frame"], rigid["triangles"]),
                         ("tool", link, len(self.scene.panda.links[link][1])))
        found = self.pairs()
        for frame, pairs in self.expected.items():
            stamp = f"{stamp_of(frame).secs}.{stamp_of(frame).nsecs:09d}"
            self.assertEqual(found.get(stamp, set()), {("tool", i, name, k) for a, i, name, k in
                                                       pairs if a == link})
        lost = config.replace(f"frame: {link}", "frame: nowhere")
        done = self.run_tool("--config", self.text("lost.yaml", lost), self.bag())
        self.assertIn("no transform has the frame 'nowhere' of 'tool'", done.stderr)
        self.assert_refused(["--config", self.text("bad.yaml", config.replace(".ply", ".stl")),
                             self.bag()], "~objects[0]/mesh is '", "no such file")

    def test_pairs_are_the_oracles(self):
        summary = self.evaluate(self.bag())
        self.assert_oracle_pairs()
        self.assertEqual(summary["cycles"], FRAMES)
        self.assertEqual(summary["topics"]["/tshirt"]["messages"], FRAMES)
        self.assertEqual(summary["runs"][0]["pairs"], sum(map(len, self.expected.values())))
        self.assertIn("link meshes", summary["configuration"]["robot"])

    def test_links_table_has_onset_and_end(self):
        self.evaluate(self.bag())
        for link in self.scene.panda.links:
            touching = [f for f, pairs in self.expected.items() if any(p[0] == link for p in pairs)]
            rows = [row for row in read_table(self.path("out/links.csv")) if row["body_a"] == link]
            self.assertEqual(sum(int(row["cycles"]) for row in rows), FRAMES)
            contact = [row for row in rows if row["state"] == "CONTACT"]
            self.assertEqual(sum(int(row["cycles"]) for row in contact), len(touching))
            if touching:
                self.assertEqual(float(contact[0]["from"]), stamp_of(touching[0]).to_sec())
                self.assertEqual(float(contact[-1]["to"]), stamp_of(touching[-1]).to_sec())
                for row, time, frame in ((contact[0], "from_s", touching[0]),
                                         (contact[-1], "to_s", touching[-1])):
                    since = stamp_of(frame) - stamp_of(0)
                    self.assertAlmostEqual(float(row[time]), since.to_sec(), delta=0.0005)

    def test_the_robot_from_a_urdf(self):
        urdf = str(DATA / "robots/panda_description/urdf/panda.urdf")
        without = [event for event in self.events if event[1] != "/contact_monitor/robot_meshes"]
        bag = self.bag("bare.bag", without)
        summary = self.evaluate(bag, "--robot-description", urdf)
        self.assert_oracle_pairs()
        self.assertEqual(summary["configuration"]["robot"], urdf)
        with open(urdf) as file:
            text = file.read()
        marked = self.text("marked.urdf", "\ufeff" + text.replace("<robot", "<!-- note: # -->\n<robot", 1))
        self.evaluate(bag, "--robot-description", marked)
        self.assert_oracle_pairs()
        dump = self.text("dump.yaml", json.dumps(text))
        self.evaluate(bag, "--robot-description", dump)
        self.assert_oracle_pairs()
        described = without + [(START, "/robot_description", String(text))]
        self.evaluate(self.bag("described.bag", described))
        self.assert_oracle_pairs()
        self.assert_refused(["--config", self.text("c.yaml", CONFIG), bag], "no robot",
                            "--robot-description")

    def test_a_link_with_visual_geometry_only(self):
        with open(DATA / "robots/panda_description/urdf/panda.urdf") as file:
            text = file.read()
        hand = text[text.index('<link name="panda_hand">'):]
        hand = hand[:hand.index("</link>")]
        begin, end = hand.index("<collision>"), hand.index("</collision>") + len("</collision>")
        urdf = self.text("bare.urdf", text.replace(hand, hand[:begin] + hand[end:]))
        without = [event for event in self.events if event[1] != "/contact_monitor/robot_meshes"]
        bag = self.bag("bare.bag", without)

        def evaluated(*arguments):
            made = self.evaluate(bag, "--robot-description", urdf, *arguments)["configuration"]
            return made["geometry"], "panda_hand" in [link["name"] for link in made["links"]]
        self.assertEqual(evaluated(), ("collision", False))
        self.assertEqual(evaluated("--geometry", "collision_or_visual"),
                         ("collision_or_visual", True))
        self.assertEqual(evaluated("--geometry", "visual"), ("visual", True))
        self.assert_refused(["--geometry", "convex", bag], "--geometry", "collision_or_visual")

    def test_links_may_touch_by_the_srdf(self):
        path = DATA / "robots/panda_description/urdf/panda.srdf"
        with open(path) as file:
            text = file.read()
        disabled = {frozenset((rule.get("link1"), rule.get("link2")))
                    for rule in ElementTree.fromstring(text).findall("disable_collisions")}
        described = [(START, "/robot_description_semantic", String(text))]
        bag, with_srdf = self.bag(), self.bag("srdf.bag", described + self.events)
        broken = self.bag("broken.bag", [(START, described[0][1], String("<r/>"))] + self.events)
        config = CONFIG + "pair_classes: [robot_deformable, robot_self]\n"

        def allowed(*arguments, config=config, stderr=""):
            done = self.run_tool("--config", self.text("self.yaml", config), *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(stderr, done.stderr)
            return {frozenset((row["body_a"], row["body_b"]))
                    for row in read_table(self.path("out/links.csv")) if row["state"] == "ALLOWED"}

        self.assertEqual(allowed(bag), set())
        self.assertEqual(allowed(bag, "--srdf", str(path)), disabled)
        self.assertEqual(allowed(bag, config=f"{config}srdf: {path}\n"), disabled)
        self.assertEqual(allowed(with_srdf), disabled)
        for srdf in "auto", path:
            robots = "robots: [{description: robot_description, srdf: %s}]\n" % srdf
            self.assertEqual(allowed(with_srdf, config=config + robots), disabled)
        self.assertEqual(allowed(with_srdf, "--srdf", "none"), set())
        self.assertEqual(allowed(broken, stderr="SRDF, line 1: there is no element 'robot'"), set())
        self.assert_refused(["--srdf", self.path("no.srdf"), bag], "no.srdf: no such file")

    def test_compressed_bags(self):
        for compression in "bz2", "lz4":
            self.evaluate(self.bag(compression + ".bag", compression=compression, chunk=4096))
            self.assert_oracle_pairs()

    def short_bag(self):
        """Four cycles, for brute force takes a third of a second for each."""
        end = stamp_of(4) + rospy.Duration(0, 4000000)  # with the transforms after the last mesh
        return self.bag("short.bag", [event for event in self.events if event[0] < end])

    def test_twice_the_same_but_for_times(self):
        bag = self.short_bag()

        def outcome():
            self.evaluate(bag, "--backends", "cpu,brute_force")
            frames = [{k: v for k, v in row.items() if not k.endswith("_ms")}
                      for row in read_table(self.path("out/frames.csv"))]
            with open(self.path("out/summary.json")) as file:
                summary = json.load(file)
            del summary["times"]
            texts = [pathlib.Path(self.path("out/" + name)).read_bytes()
                     for name in ("distances.csv", "links.csv", "pairs.csv")]
            return json.dumps([frames, summary], sort_keys=True), texts
        first = outcome()
        shutil.rmtree(self.path("out"))
        self.assertEqual(first, outcome())

    def test_backends_are_compared_as_sets(self):
        summary = self.evaluate(self.short_bag(), "--backends", "cpu,brute_force,fcl",
                                "--overlaps", "1,0")
        self.assertEqual(summary["cycles"], 4)
        self.assertEqual([run["name"] for run in summary["runs"]],
                         ["cpu exact", "brute_force exact", "fcl", "cpu exact, overlap 0",
                          "brute_force exact, overlap 0", "fcl"])
        first = summary["comparisons"][0]
        self.assertEqual((first["second"], first["must_agree"], first["cycles_that_differ"]),
                         ("brute_force exact", True, 0))
        self.assertFalse(summary["comparisons"][1]["must_agree"])
        self.assertFalse(summary["comparisons"][2]["must_agree"])

    def test_without_a_configuration_recorded_meshes_are_objects(self):
        done = self.run_tool("--reference-frame", "panda_link0", "--pairs", self.bag())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_oracle_pairs()
        # The root of the transforms is panda_link0; base_link, the default, is not there.
        done = self.run_tool("--pairs", self.bag())
        self.assertIn("'panda_link0', the root", done.stderr)
        self.assert_oracle_pairs()
        done = self.run_tool("--reference-frame", "elsewhere", self.bag())
        self.assertIn("no transform knows the reference frame 'elsewhere'", done.stderr)
        self.assertEqual({row["complete"] for row in read_table(self.path("out/frames.csv"))},
                         {"no"})

    def test_report(self):
        self.evaluate(self.bag(), "--backends", "cpu,fcl", report=True)
        with open(self.path("out/report.html")) as file:
            report = file.read()
        self.assertEqual(report.count("<svg"), 4)
        self.assertIn("panda_hand / tshirt", re.sub(r"<!--|-->", "", report))
        stages = re.findall("<!-- (transform|cluster|assign|sort|sweep|narrow_phase|output) -->", report)
        self.assertEqual(stages, ["transform", "cluster", "assign", "sort", "sweep", "narrow_phase", "output"])

    def report_module(self):
        script = pathlib.Path(TOOL).with_name("evaluation_report.py")
        spec = importlib.util.spec_from_file_location("evaluation_report", script)
        report = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(report)
        return report

    def test_no_line_is_drawn_where_a_distance_is_not_known(self):
        bodies = {"run": "cpu", "body_a": "hand", "body_b": "cloth"}
        distances = [{**bodies, "stamp": str(stamp), "distance": "0.25"} for stamp in (1, 2, 8, 9)]
        for state, is_broken in (("UNKNOWN", True), ("NONE", True), ("NEAR", False)):
            links = [{**bodies, "state": state, "from": "2.5", "to": "8"}]
            line = self.report_module().distances_of(distances, links, "cpu")["hand", "cloth"]
            self.assertEqual([stamp for stamp, d in line if math.isnan(d)], [2.5] * is_broken)
            self.assertEqual(line, sorted(line, key=lambda point: point[0]))

    def test_a_long_line_is_drawn_by_few_points_with_its_extremes_and_gaps(self):
        report = self.report_module()
        for count in (0, 1, report.MOST_POINTS, 3 * report.MOST_POINTS + 1, 100000):
            line = [(x, math.sin(x / 100)) for x in range(count)]
            if count > report.MOST_POINTS:
                line[count // 3] = (count // 3, math.nan)
                line[count // 2] = (count // 2, -7.0)
                line[count // 2 + 1] = (count // 2 + 1, 7.0)
            drawn = report.drawn(line)
            self.assertLessEqual(len(drawn), report.MOST_POINTS)
            self.assertEqual(drawn, sorted(drawn, key=lambda point: point[0]))
            self.assertLessEqual({x for x, _ in drawn}, {x for x, _ in line})
            if count > report.MOST_POINTS:
                self.assertLessEqual({count // 3, count // 2, count // 2 + 1},
                                     {x for x, _ in drawn})

    def test_a_disk_that_is_full_leaves_no_half_a_report(self):
        self.evaluate(self.bag(), report=True)
        os.remove(self.path("out/report.html"))
        before = sorted(os.listdir(self.path("out")))
        done = subprocess.run(
            [str(pathlib.Path(TOOL).with_name("evaluation_report.py")), self.path("out")],
            stderr=subprocess.PIPE, text=True, check=False, restore_signals=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("evaluation_report.py: ", done.stderr)
        self.assertEqual(sorted(os.listdir(self.path("out"))), before)

    def test_nothing_of_an_earlier_evaluation_is_left(self):
        self.evaluate(self.bag(), report=True)
        self.assertTrue(os.path.exists(self.path("out/report.html")))
        done = self.run_tool("--config", self.path("config.yaml"), "--no-report", self.bag())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(set(os.listdir(self.path("out"))),
                         {"distances.csv", "events.csv", "frames.csv", "links.csv", "summary.json"})

    def test_bad_input(self):
        config = self.text("config.yaml", CONFIG)
        bag = self.bag()
        whole = pathlib.Path(bag).read_bytes()
        cut = self.path("cut.bag")
        pathlib.Path(cut).write_bytes(whole[:len(whole) // 2])
        self.assert_refused(["--config", config, cut], "cut.bag", "rosbag reindex " + cut)
        unindexed = self.path("unindexed.bag")
        pathlib.Path(unindexed).write_bytes(re.sub(rb"index_pos=.{8}", b"index_pos=" + bytes(8),
                                                   whole, count=1, flags=re.DOTALL))
        self.assert_refused(["--config", config, unindexed], "no index",
                            "rosbag reindex " + unindexed)
        self.assert_refused(["--config", config, self.path("no.bag")], "no.bag", "cannot be read")
        self.assert_refused(["--config", config, self.folder], "cannot be read")
        merged = self.text("merged.yaml", CONFIG + "defaults: &d {margin_m: 0.5}\n<<: *d\n")
        self.assert_refused(["--config", merged, self.bag()], "merge keys (<<) are not supported")
        expect = "# the hand\n---\n- {link: panda_hand, object: tshirt, touches: never}\n"
        for more in ("---\n" + expect, "...\n\n" + expect[15:]):
            two = self.text("two.yaml", expect + more)
            self.assert_refused(["--config", config, "--expect", two, self.bag()],
                                "two.yaml: a second document begins in line ")
        self.assert_refused(["--config", config, self.text("empty.bag", "")], "is empty")
        self.assert_refused(["--config", config, self.text("text.bag", "hello")], "is no bag")
        self.assert_refused([], "BAG")
        transforms = [event for event in self.events if event[1] != "/tshirt"]
        self.assert_refused(["--config", config, self.bag("foreign.bag", transforms)],
                            "no deformable mesh", "--object")
        other = self.text("other.yaml", CONFIG.replace("/tshirt", "/trousers"))
        self.assert_refused(["--config", other, bag], "no object of it", "/tshirt")
        wrong = self.text("wrong.yaml", CONFIG + "overlap: 7\n")
        self.assert_refused(["--config", wrong, bag], "wrong.yaml", "overlap")
        broken = self.text("broken.yaml", "objects: [\n")
        self.assert_refused(["--config", broken, bag], "broken.yaml", "line")
        self.assert_refused(["--config", config, bag, "--expect", self.text("x.yaml", "- {a: 1}")],
                            "x.yaml", "link and object")
        self.text("out", "in the way")
        self.assert_refused(["--config", config, bag], "out: cannot be made")
        os.remove(self.path("out"))
        self.assert_refused(["--config", config, bag, "--backends", "gpu"], "gpu")
        self.assert_refused(["--config", config, bag, "--threads", "-1"], "--threads")
        for option in ("--part", "--records", "--join"):  # of version 0.2
            self.assert_refused(["--config", config, bag, option, "1/2"], option)

    def test_what_is_called_cuda_ran_with_cuda(self):
        done = self.run_tool("--config", self.text("config.yaml", CONFIG), self.bag(), "--backends",
                             "cpu,cuda")
        if done.returncode == 2:  # no device here
            self.assertIn("CUDA", done.stderr.splitlines()[-1])
            return
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = read_table(self.path("out/frames.csv"))
        self.assertEqual({row["backend"] for row in rows}, {"cpu", "cuda"})
        self.assertEqual({row["differs"] for row in rows}, {"no"})


if __name__ == "__main__":
    main()
