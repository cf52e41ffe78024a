#!/usr/bin/env python3
"""evaluate_bag on bags with several topics of a kind, with topics of unusual names, and with frames
that have a prefix: what is ambiguous is refused by name, what is left out is named, and what was
chosen is read alone. The tool is $EVALUATE_BAG."""
import csv
import json
import os
import re
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import rosbag
import rospy
from deformable_contact_monitor.msg import DeformableMesh, LinkMesh, LinkMeshes
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

TOOL = os.environ["EVALUATE_BAG"]
CYCLES, START, PERIOD_S = 5, 100, 0.1
URDF = """<robot name="r"><link name="base_link"/>
<link name="finger"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="base_link"/><child link="finger"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
BOX = ([x for corner in range(8) for x in (0.05 * (2 * (corner & 1) - 1), 0.05 * ((corner & 2) - 1),
                                          0.05 * ((corner & 4) / 2 - 1))],
       [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
        1, 3, 5, 3, 7, 5])


def stamp_of(i):
    return rospy.Time(START) + rospy.Duration.from_sec(i * PERIOD_S)


def mesh(i, name="cloth", height=0.0, scale=1.0, frame="base_link"):
    """A horizontal square of 1 m."""
    message = DeformableMesh(object=name, topology_id=1, triangles=[0, 1, 2, 1, 3, 2])
    message.header.stamp, message.header.frame_id = stamp_of(i), frame
    for x, y in ((-.5, -.5), (.5, -.5), (-.5, .5), (.5, .5)):
        message.vertices += [scale * x, scale * y, scale * height]
    return message


def transform(i, parent, child, z=0.0):
    moved = TransformStamped(child_frame_id=child)
    moved.header.frame_id, moved.header.stamp = parent, stamp_of(i)
    moved.transform.translation.z, moved.transform.rotation.w = z, 1
    return TFMessage([moved])


def joints(i, position=0.0):
    message = JointState(name=["j"], position=[position])
    message.header.stamp = stamp_of(i)
    return message


def links(height=0.0):
    vertices = [v + (height if i % 3 == 2 else 0) for i, v in enumerate(BOX[0])]
    return LinkMeshes(meshes=[LinkMesh("finger", "test", vertices, BOX[1])])


def finger(z=0.0, prefix="", topic="/tf"):
    return topic, lambda i: transform(i, prefix + "base_link", prefix + "finger", z)


def cloth(topic="/cloth/mesh", **options):
    return topic, lambda i: mesh(i, **options)


def always(topic, message):
    return topic, lambda _: message


class BagTopics(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.urdf = self.text("r.urdf", URDF)

    def path(self, name):
        return os.path.join(self.folder, name)

    def text(self, name, content):
        pathlib.Path(self.path(name)).write_text(content)
        return self.path(name)

    def bag(self, *streams, name="a.bag"):
        with rosbag.Bag(self.path(name), "w") as file:
            for i in range(-1, CYCLES + 1):
                for topic, make in streams:
                    if 0 <= i < CYCLES or "mesh" not in topic or "robot" in topic:
                        file.write(topic, make(i), stamp_of(i))
        return self.path(name)

    def run_tool(self, bag, *arguments, robot=True):
        more = ("--robot-description", self.urdf) if robot else ()
        return subprocess.run([TOOL, bag, "--out", self.path("out"), "--no-report", *more, *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, check=False)

    def states(self, bag, *arguments, says=(), robot=True):
        """{object: states of the finger with it}, each in all cycles. `says`: in the warnings."""
        done = self.run_tool(bag, *arguments, robot=robot)
        self.assertEqual(done.returncode, 0, done.stderr)
        for words in says:
            self.assertIn(words, done.stderr)
        if not says:
            # A busy machine shows its progress: lines that end with a time.
            said = [line for line in done.stderr.splitlines() if not re.search(r"\(\d+ s", line)]
            self.assertEqual(said, [])
        found = {}
        with open(self.path("out/links.csv"), newline="") as file:
            for row in csv.DictReader(file):
                self.assertEqual(int(row["cycles"]), CYCLES)
                found.setdefault(row["body_b"], set()).add(row["state"])
        return found

    def assert_refused(self, bag, *arguments, says, robot=True):
        done = self.run_tool(bag, *arguments, robot=robot)
        self.assertEqual(done.returncode, 2, done)
        last = done.stderr.splitlines()[-1]
        for words in says:
            self.assertIn(words, last)
        return done.stderr

    def test_other_topics_of_transforms_are_left_out(self):
        bag = self.bag(cloth(), finger(1.0), finger(0.0, topic="/ghost/tf"))
        left_out = "/ghost/tf are left out; to read them too, give --tf-topic /tf,/ghost/tf"
        self.assertEqual(self.states(bag, says=[left_out]), {"cloth": {"NONE"}})
        self.assertEqual(self.states(bag, "--tf-topic", "/ghost/tf", says=["/tf are left out"]),
                         {"cloth": {"CONTACT"}})

    def test_transforms_on_other_topics_alone_are_proposed(self):
        static = ("left/tf_static", lambda i: transform(i, "base_link", "finger"))
        bag = self.bag(cloth(), ("/left/tf", lambda i: transform(i, "world", "base_link")), static)
        proposed = "give --tf-topic /left/tf"
        self.assert_refused(bag, says=["/left/tf, /left/tf_static", proposed])
        self.assertEqual(self.states(bag, "--tf-topic", "left/tf"), {"cloth": {"CONTACT"}})
        self.assert_refused(bag, "--tf-topic", "/right/tf", says=["--tf-topic /right/tf", "/left/tf"])
        self.assert_refused(bag, "--object", "cloth", "--vertices", "36", "--name", "new", says=[proposed])

    def test_link_meshes_of_two_monitors(self):
        bag = self.bag(cloth(), finger(), always("/a/robot_meshes", links()),
                       always("/b/robot_meshes", links(1.0)))
        frame = ("--reference-frame", "base_link")
        self.assert_refused(bag, *frame, robot=False, says=["/a/robot_meshes, /b/robot_meshes",
                                                            "--robot-meshes-topic"])
        for topic, state in ("a/robot_meshes", "CONTACT"), ("/b/robot_meshes", "NONE"):
            self.assertEqual(self.states(bag, *frame, "--robot-meshes-topic", topic, robot=False),
                             {"cloth": {state}})
        self.assertEqual(self.states(bag), {"cloth": {"CONTACT"}})  # by the URDF
        self.assert_refused(bag, *frame, "--robot-meshes-topic", "/c/robot_meshes", robot=False,
                            says=["--robot-meshes-topic /c/robot_meshes", "/b/robot_meshes"])

    def test_two_robot_descriptions(self):
        small = URDF.replace("0.1 0.1 0.1", "1 1 0.01")
        bag = self.bag(cloth(), finger(0.02), always("/robot_description", String(URDF)),
                       always("/left/robot_description", String(small)))
        self.assert_refused(bag, robot=False, says=["/left/robot_description, /robot_description",
                                                    "--robot-description-topic"])
        for topic, state in ("/robot_description", "CONTACT"), ("left/robot_description", "NONE"):
            self.assertEqual(self.states(bag, "--robot-description-topic", topic, robot=False),
                             {"cloth": {state}})
        self.assert_refused(bag, "--robot-description-topic", "/x", robot=False,
                            says=["/x", "/left/robot_description"])
        self.assert_refused(bag, "--robot-description-topic", "/x", says=["not together"])

    def test_one_name_on_two_topics(self):
        bag = self.bag(cloth("/cam1/mesh"), cloth("/cam2/mesh", height=1), finger(),
                       cloth("/other/mesh", name="other"))
        self.assert_refused(bag, says=["'cloth' is on /cam1/mesh, /cam2/mesh",
                                       "--topic cloth=/cam1/mesh"])
        self.assertEqual(self.states(bag, "--topic", "cloth=cam2/mesh",
                                     says=["the meshes on /cam1/mesh are left out"]),
                         {"cloth": {"NONE"}, "other": {"CONTACT"}})
        for choice, words in (("cloth=/x", "/cam1/mesh, /cam2/mesh"), ("cloth", "OBJECT=TOPIC"),
                              ("sheet=/cam1/mesh", "are of object 'cloth'"), ("=/x", "OBJECT=TOPIC"),
                              ("a=/x,a=/y", "has two topics"), ("a=/x,b=x", "of two objects")):
            self.assert_refused(bag, "--topic", choice, says=["--topic", words])

    def test_meshes_without_names(self):
        bag = self.bag(cloth("/cam1/mesh", name=""), cloth("/cam2/mesh", name="", height=1), finger())
        self.assert_refused(bag, says=["'mesh' is on /cam1/mesh, /cam2/mesh"])
        self.assertEqual(self.states(bag, "--topic", "a=/cam1/mesh", "--topic", "b=/cam2/mesh"),
                         {"a": {"CONTACT"}, "b": {"NONE"}})

    def test_topics_of_configured_objects(self):
        bag = self.bag(cloth("/cam1/mesh"), cloth("/cam2/mesh", height=1), finger())
        config = ("--config", self.text("c.yaml", "objects: [{name: cloth, topic: /cam1/mesh}]"))
        self.assertEqual(self.states(bag, *config), {"cloth": {"CONTACT"}})
        self.assertEqual(self.states(bag, *config, "--topic", "cloth=/cam2/mesh"),
                         {"cloth": {"NONE"}})
        self.assert_refused(bag, *config, "--topic", "clot=/cam2/mesh", says=["did you mean 'cloth'"])
        self.text("c.yaml", "objects: [{name: cloth, topic: /cam1/mesh}, {name: b, topic: cam1/mesh}]")
        self.assert_refused(bag, *config, says=["'cloth' and 'b' have one topic, /cam1/mesh"])
        self.text("c.yaml", "objects: [{name: b, topic: /cam1/mesh, type: marker}]")
        done = self.assert_refused(bag, *config, says=["no object of it"])
        self.assertIn("DeformableMesh was recorded, and not visualization_msgs/Marker", done)

    def test_an_object_is_recorded_or_played(self):
        bag = self.bag(cloth(), finger())
        self.assert_refused(bag, "--object", "cloth", says=["recorded on /cloth/mesh", "--name"])

    def test_an_object_is_not_played_for_years(self):
        """The clock leapt: one frame moves only before that, and another one only after it."""
        bag = self.path("leap.bag")
        with rosbag.Bag(bag, "w") as file:
            for child, first in (("camera", 0), ("finger", 10**10)):
                for i in range(first, first + CYCLES):
                    file.write("/tf", transform(i, "base_link", child), stamp_of(i))
        self.assert_refused(bag, "--object", "cloth", "--vertices", "36", says=["the clock leapt"])

    def test_joint_states_on_another_topic(self):
        bag = self.bag(cloth(), ("/robot/joint_states", joints))
        proposed = "give --joint-states /robot/joint_states"
        self.assert_refused(bag, says=[proposed])
        self.assert_refused(bag, "--object", "cloth", "--vertices", "36", "--name", "new", says=[proposed])
        self.assertEqual(self.states(bag, "--joint-states", "robot/joint_states"),
                         {"cloth": {"CONTACT"}})
        self.assert_refused(bag, "--joint-states", "/x", says=["--joint-states /x", "/robot/joint"])

    def test_names_without_a_slash(self):
        bag = self.bag(cloth("cloth/mesh"), finger(topic="tf"))
        self.assertEqual(self.states(bag), {"cloth": {"CONTACT"}})
        self.assertEqual(self.states(self.bag(cloth("cloth/mesh"), ("joint_states", joints))),
                         {"cloth": {"CONTACT"}})
        config = self.text("c.yaml", "objects: [{name: cloth, topic: /cloth/mesh}]")
        self.assertEqual(self.states(bag, "--config", config), {"cloth": {"CONTACT"}})

    def test_frames_with_a_prefix(self):
        bag = self.bag(cloth(frame="left/base_link"), finger(prefix="left/"))
        proposed = "there is 'left/finger': set frame_prefix to 'left/'"
        self.assert_refused(bag, says=[proposed, "give --frame-prefix"])
        self.assertEqual(self.states(bag, "--frame-prefix", "left/"), {"cloth": {"CONTACT"}})
        with open(self.path("out/summary.json")) as file:
            configuration = json.load(file)["configuration"]
        self.assertEqual((configuration["frame_prefix"], configuration["reference_frame"]),
                         ("left/", "left/base_link"))
        config = self.text("c.yaml", "{frame_prefix: left/, reference_frame: left/base_link,"
                                     " objects: [{name: cloth, topic: /cloth/mesh}]}")
        self.assertEqual(self.states(bag, "--config", config), {"cloth": {"CONTACT"}})
        of_joints = self.bag(cloth(frame="left/base_link"), ("/joint_states", lambda i: joints(i, 1)))
        self.assertEqual(self.states(of_joints, "--frame-prefix", "left/"), {"cloth": {"NONE"}})

    def test_robots_of_a_list(self):
        bag = self.bag(cloth(frame="a/base_link"), finger(prefix="a/"), finger(1.0, prefix="b/"),
                       ("/tf", lambda i: transform(i, "a/base_link", "b/base_link")),
                       always("/arm", String(URDF)), always("/other", String(URDF)))
        text = """{reference_frame: a/base_link, objects: [{name: cloth, topic: /cloth/mesh}],
                   robots: [{description: %s, frame_prefix: a/}, {description: /arm, frame_prefix: %s}]}"""
        config = ("--config", self.text("c.yaml", text % ("arm", "b/")))
        self.assertEqual(self.states(bag, *config, robot=False), {"cloth": {"CONTACT", "NONE"}})
        with open(self.path("out/links.csv"), newline="") as file:
            self.assertEqual({row["body_a"]: row["state"] for row in csv.DictReader(file)},
                             {"a/finger": "CONTACT", "b/finger": "NONE"})
        sent = LinkMeshes(meshes=[LinkMesh(arm + "/finger", "test", *BOX) for arm in "ab"])
        recorded = self.bag(cloth(frame="a/base_link"), finger(prefix="a/"), finger(1.0, prefix="b/"),
                            ("/tf", lambda i: transform(i, "a/base_link", "b/base_link")),
                            always("/contact_monitor/robot_meshes", sent), name="recorded.bag")
        self.assertEqual(self.states(recorded, *config, robot=False),
                         {"cloth": {"CONTACT", "NONE"}})
        for option in "--robot-description", "--frame-prefix", "--srdf", "--robot-description-topic":
            self.assert_refused(bag, *config, option, "x", robot=False,
                                says=[option + " is of a single robot, but", "has robots"])
        self.text("c.yaml", text % ("/lost", "b/"))
        self.assert_refused(bag, *config, robot=False, says=["nor a URDF on /lost"])
        self.text("c.yaml", text % ("/other", "a/"))
        self.assert_refused(bag, *config, robot=False,
                            says=["robots: 'a/base_link' is a link of robots[0], 'r'"])

    def test_the_node_s_warnings(self):
        config = self.text("c.yaml", """{objects: [{name: cloth, topic: /cloth/mesh}],
          containment: true, link_margin_m: {figner: 1e-3}, margin_m: 1e-3,
          allowed_contacts: [{body_a: finger, body_b: clot}]}""")
        self.urdf = self.text("bad.urdf", URDF.replace('<link name="base_link"/>', """
          <link name="base_link"><collision><geometry><box size="900 900 900"/></geometry></collision>
          </link><link name="lost"><collision><geometry><mesh filename="file:///lost.stl"/></geometry>
          </collision></link><joint name="k" type="fixed"><parent link="base_link"/>
          <child link="lost"/></joint>"""))
        warnings = self.run_tool(self.bag(cloth(), finger()), "--config", config).stderr
        for words in ("did you mean 'finger'?), which is no link", "did you mean 'cloth'?), which is no",
                      "lost.stl", "if its file is in millimetres", "1 of 1 parts of 'cloth' are not"):
            self.assertIn(words, warnings)
        self.urdf = self.text("r.urdf", URDF)
        self.assertEqual(self.states(self.bag(cloth(scale=1000, height=.01), finger()), says=[
            "object 'cloth': its mesh is 1000 m long", "is it in millimetres?"]), {"cloth": {"NONE"}})


if __name__ == "__main__":
    unittest.main()
