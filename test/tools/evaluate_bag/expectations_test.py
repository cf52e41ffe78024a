#!/usr/bin/env python3
"""What evaluate_bag makes of expectations and of what it could not find out: verdicts, reasons,
exit codes."""
import copy
import re

import rospy
from tf2_msgs.msg import TFMessage

from evaluation_case import CONFIG, EvaluationCase, main, of_time, read_table
from panda_bag import AWAY_FROM, FRAMES, stamp_of


class Expectations(EvaluationCase):

    def test_expectations(self):
        good = self.text("good.yaml", """\ufeff# the hand
--- # begins
- {link: panda_hand, object: tshirt, touches: sometime}
- {link: panda_hand, object: tshirt, touches: never, from_s: 0.6}
...
# ends
""")
        touched = {pair[0] for pairs in self.expected.values() for pair in pairs}
        self.assertIn("panda_hand", touched)
        summary = self.evaluate(self.bag(), "--expect", good)
        self.assertEqual([e["holds"] for e in summary["expectations"]], [True, True])

        bad = self.text("bad.yaml", """
- {link: panda_hand, object: tshirt, touches: never}
- {link: tshirt, object: panda_hand, touches: always}
- {link: panda_hand, object: tshirt, touches: sometime, from_s: 0.6, to_s: 100}
- {link: panda_hand, object: tshirt, touches: sometime, min_pairs: 100000}
- {link: panda_hand, object: tshirt, touches: never, from_s: 50}
- {link: no_link, object: tshirt, touches: never}
""")
        summary = self.evaluate(self.bag(), "--expect", bad, code=1)
        failures = [e["failure"] for e in summary["expectations"]]
        for failure, words in zip(failures, ["CONTACT", "NONE", "not once", "most pairs",
                                             "no cycle", "no such body 'no_link'"]):
            self.assertIn(words, failure)
        self.assertFalse(summary["passed"])

    def test_a_part_is_a_body_of_expectations_and_tables(self):
        touched = sorted({triangle for pairs in self.expected.values()
                          for link, _, _, triangle in pairs if link == "panda_hand"})
        other = next(i for i in range(len(touched) + 1) if i not in touched)
        hem = self.text("hem.txt", "".join(f"{triangle}\n" for triangle in touched))
        config = self.text("parts.yaml", f"""
reference_frame: panda_link0
objects: [{{name: tshirt, topic: /tshirt, parts: [
  {{name: hem, indices_file: {hem}}}, {{name: other, triangles: [[{other}, {other}]]}}]}}]
""")
        expect = self.text("e.yaml", """
- {link: panda_hand, object: 'tshirt:hem', touches: sometime}
- {link: panda_hand, object: 'tshirt:other', touches: never}
- {link: panda_hand, object: 'tshirt:hen', touches: never}
""")
        done = self.run_tool("--config", config, "--expect", expect, self.bag())
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual([e["failure"] for e in self.summary()["expectations"]], [
            "", "", "no such body 'tshirt:hen' (did you mean 'tshirt:hem'?)"])
        rows = {(row["body_b"], row["state"]) for row in read_table(self.path("out/links.csv"))
                if row["body_a"] == "panda_hand"}
        self.assertTrue({("tshirt:hem", "CONTACT"), ("tshirt:other", "NONE")} <= rows, rows)

        with open(config, "a") as file:
            file.write("allowed_contacts: [{body_a: panda_hand, body_b: 'tshirt:hem'}]\n")
        expect = self.text("e.yaml", "- {link: panda_hand, object: tshirt, touches: never}")
        done = self.run_tool("--config", config, "--expect", expect, self.bag())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_unknown_is_not_never(self):
        gap = [e for e in self.events if e[1] != "/tf" or stamp_of(3) > e[0] or e[0] > stamp_of(18)]
        gap = [(t, topic, TFMessage([x for x in m.transforms if x.child_frame_id != "panda_hand"]))
               if topic == "/tf" and t > stamp_of(18) else (t, topic, m) for t, topic, m in gap]
        expect = self.text("e.yaml", "- {link: panda_hand, object: tshirt, touches: never, "
                                     "from_s: 0.65}")
        summary = self.evaluate(self.bag("gap.bag", gap), "--expect", expect, code=1)
        self.assertIn("UNKNOWN", summary["expectations"][0]["failure"])
        self.assertLess(summary["runs"][0]["complete_cycles"], FRAMES)
        self.assertIn("panda_hand: TF", read_table(self.path("out/frames.csv"))[-1]["skipped"])

    def test_a_recording_is_judged_where_it_holds_transforms(self):
        def known(first, last):
            return [e for e in self.events
                    if e[1] != "/tf" or stamp_of(first - 0.5) < e[0] < stamp_of(last + 0.5)]

        def judged(events, text, code):
            summary = self.evaluate(self.bag("edges.bag", events), "--expect",
                                    self.text("e.yaml", text), code=code)
            return summary["unjudged_cycles"], [e["failure"] for e in summary["expectations"]]

        away_s = (stamp_of(AWAY_FROM) - stamp_of(0)).to_sec()
        text = f"""
- {{link: panda_hand, object: tshirt, touches: sometime, to_s: {away_s - 0.001}}}
- {{link: panda_hand, object: tshirt, touches: never, from_s: {away_s - 0.001}}}
"""
        self.assertEqual(judged(known(2, FRAMES - 3), text, 0), (4, ["", ""]))
        # A link whose transforms end before those of the others is judged.
        lost = [e if e[1] != "/tf" or e[0] < stamp_of(AWAY_FROM) else
                (e[0], e[1], TFMessage([x for x in e[2].transforms
                                        if x.child_frame_id != "panda_hand"]))
                for e in known(2, FRAMES - 3)]
        unjudged, failures = judged(lost, text, 1)
        self.assertEqual((unjudged, failures[0]), (4, ""))
        self.assertIn("UNKNOWN", failures[1])
        # A mesh that came 1.5 s earlier moves the two first frames beyond the edge.
        early = copy.deepcopy(next(e[2] for e in self.events if e[1] == "/tshirt"))
        early.header.stamp -= rospy.Duration(1.5)
        unjudged, failures = judged([(early.header.stamp, "/tshirt", early)] + known(2, FRAMES - 3),
                                    "- {link: panda_hand, object: tshirt, touches: never, "
                                    "to_s: 1.51}", 1)
        self.assertEqual(unjudged, 1)
        self.assertIn("at 1.500 s: UNKNOWN", failures[0])

    def test_where_the_clock_goes_back_cycles_are_judged_as_well(self):
        """The shirt is far off until a simulator starts anew, and then in contact for 1.8 s."""
        robot, *rest = self.events
        away = [e for e in rest if e[0] >= stamp_of(AWAY_FROM - 0.5)]
        anew = [(received + rospy.Duration(later_s), topic, of_time(message, later_s - 60))
                for later_s in (30, 30.64, 31.28) for received, topic, message in rest
                if received < stamp_of(AWAY_FROM - 0.5)]
        bag = self.bag("anew.bag", [robot] + away + anew)
        expect = self.text("e.yaml", """
- {link: panda_hand, object: tshirt, touches: never}
- {link: panda_hand, object: tshirt, touches: sometime, from_s: 0.1}
- {link: panda_hand, object: tshirt, touches: never, to_s: 0.1}
""")
        summary = self.evaluate(bag, "--expect", expect, code=1)
        self.assertEqual(summary["cycles"], FRAMES - AWAY_FROM + 3 * AWAY_FROM)
        self.assertEqual([e["holds"] for e in summary["expectations"]], [False, True, True],
                         summary["expectations"])

    def test_only_a_second_without_transforms_is_an_edge(self):
        """The publisher of transforms died, two seconds before the recording ended."""
        events = [e for e in self.events if e[1] != "/tf" or e[0] < stamp_of(AWAY_FROM + 2.5)]
        late = copy.deepcopy(next(e[2] for e in self.events if e[1] == "/tshirt"))
        late.header.stamp = stamp_of(AWAY_FROM) + rospy.Duration(2)
        text = "- {{link: panda_hand, object: tshirt, touches: never, from_s: {}, to_s: {}}}"
        away_s = (stamp_of(AWAY_FROM) - stamp_of(0)).to_sec() - 0.001
        bag = self.bag("died.bag", events + [(late.header.stamp, "/tshirt", late)])
        expect = self.text("e.yaml", "\n".join(text.format(away_s, to_s) for to_s in (1, 3)))
        expectations = self.evaluate(bag, "--expect", expect, code=1)["expectations"]
        self.assertEqual([e["holds"] for e in expectations], [True, False])
        self.assertIn("UNKNOWN", expectations[1]["failure"])

    def test_only_missing_transforms_are_forgiven_at_an_edge(self):
        """A frame that nobody needs begins late, and some meshes have a vertex that is no number."""
        events = []
        for received, topic, message in self.events:
            message = copy.deepcopy(message)
            if topic == "/tf" and received > stamp_of(6):
                message.transforms.append(copy.deepcopy(message.transforms[0]))
                message.transforms[-1].child_frame_id = "other_camera"
            if topic == "/tshirt" and stamp_of(2) <= message.header.stamp <= stamp_of(4):
                message.vertices = [float("nan")] + list(message.vertices[1:])
            events.append((received, topic, message))
        text = "- {link: panda_link0, object: tshirt, touches: never, to_s: 0.2}"
        summary = self.evaluate(self.bag("nan.bag", events), "--expect",
                                self.text("e.yaml", text), code=1)
        self.assertIn("not finite", summary["expectations"][0]["failure"])
        self.assertEqual(summary["unjudged_cycles"], 0)

    def failures(self, text, *arguments):
        """Of expectations, by the first cycle's words; and what was said on standard error."""
        expect = self.text("e.yaml", text)
        done = self.run_tool("--config", self.text("c.yaml", CONFIG), "--expect", expect, *arguments)
        self.assertEqual(done.returncode, 1, done.stderr)
        return [e["failure"] for e in self.summary()["expectations"]], done.stderr

    def test_a_body_that_does_not_exist_is_called_so(self):
        failures, said = self.failures("""
- {link: panda_hnad, object: tshirt}
- {link: panda_hand, object: t_shirt, touches: always}
- {link: something_else, object: tshirt, touches: never}
- {link: panda_hand, object: panda_link0, touches: never}
- {link: panda_hand, object: panda_link1}
""", self.bag())
        self.assertEqual(failures[:3], ["no such body 'panda_hnad' (did you mean 'panda_hand'?)",
                                        "no such body 't_shirt' (did you mean 'tshirt'?)",
                                        "no such body 'something_else'"])
        for failure in failures[3:]:  # robot_self is off
            self.assertIn("not monitored: no pair class", failure)
        self.assertIn("warning: " + self.path("e.yaml") + ": no such body 'panda_hnad'", said)

    def test_a_link_without_geometry_is_no_body(self):
        without = [event for event in self.events if event[1] != "/contact_monitor/robot_meshes"]
        failures, _ = self.failures("- {link: panda_link8, object: tshirt, touches: never}",
                                    self.bag(events=without), "--robot-description",
                                    self.scene.panda.urdf)
        self.assertEqual(failures, ["link 'panda_link8' has no geometry, or is left out"])

    def test_nothing_that_could_be_evaluated_is_an_error(self):
        done = self.assert_refused(["--reference-frame", "elsewhere", self.bag()],
                                   "no cycle could be evaluated", "elsewhere",
                                   "--reference-frame", "panda_link0", self.path("out"), report=True)
        self.assertIn("Failed: no cycle could be evaluated.", done.stdout)
        self.assertFalse(self.summary()["passed"])
        self.assertEqual(self.summary()["runs"][0]["evaluated_cycles"], 0)
        self.assertIn("no cycle could be evaluated", self.report())

        bare = [event if event[1] != "/tshirt" else (*event[:2], self.bare(event[2]))
                for event in self.events]
        self.assert_refused(["--config", self.text("c.yaml", CONFIG), self.bag(events=bare)],
                            "no cycle could be evaluated", "no triangles of topology_id 1",
                            "once a second")
        no_pair = self.text("n.yaml", CONFIG + "pair_classes: [deformable_deformable]\n")
        self.assert_refused(["--config", no_pair, self.bag()], "no cycle could be evaluated",
                            "pair_classes")

    @staticmethod
    def bare(mesh):
        mesh = copy.copy(mesh)
        mesh.triangles = []
        return mesh

    def test_one_cycle_is_enough_to_pass(self):
        lone = [e for e in self.events if e[1] != "/tf" or abs(e[0] - stamp_of(7)).to_sec() < 0.02]
        summary = self.evaluate(self.bag(events=lone))
        self.assertEqual(summary["runs"][0]["evaluated_cycles"], 1)
        self.assertEqual(summary["runs"][0]["whole_cycles"], 1)
        self.assertIn(f"{FRAMES - 1} of {FRAMES} cycles had something missing", summary["verdict"])

    def test_reasons_are_counted_and_shown(self):
        hidden = range(4, 9)
        events = []
        for received, topic, message in self.events:
            frame = round((received - stamp_of(0)).to_sec() / 0.04)
            if topic == "/tf" and frame in hidden:
                kept = [t for t in message.transforms if t.child_frame_id != "panda_hand"]
                message = TFMessage(kept)
            if topic == "/tf" and frame >= 15:
                kept = [t for t in message.transforms if t.child_frame_id != "panda_link3"]
                message = TFMessage(kept)
            events.append((received, topic, message))
        summary = self.evaluate(self.bag(events=events), report=True)
        reasons = summary["runs"][0]["unknown"]
        # What is missing in between, TF interpolates; what ends, takes all with it that hangs on it.
        below = {"panda_link3", "panda_link4", "panda_link5", "panda_link6", "panda_link7",
                 "panda_hand", "panda_leftfinger", "panda_rightfinger"}
        self.assertEqual({re.match("([a-z0-9_]+): TF from '", r["reason"]).group(1)
                          for r in reasons}, below)
        for reason in reasons:
            self.assertEqual(reason["cycles"], FRAMES - 15)
            self.assertIn("is late", reason["reason"])
            stamps = [f"{stamp_of(f).secs}.{stamp_of(f).nsecs:09d}" for f in (15, FRAMES - 1)]
            self.assertEqual([reason["from"], reason["to"]], stamps)
        page = self.report()
        self.assertIn("UNKNOWN since", page)
        for link in below:
            self.assertRegex(page, f"<td>{link}: TF from [^<]* is late[^<]*</td><td>5</td>")

    def test_what_guarantees_nothing_does_not_look_incomplete(self):
        done = self.run_tool("--config", self.text("c.yaml", CONFIG), "--backends", "fcl,cpu",
                             self.bag(), report=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        fcl, cpu = self.summary()["runs"]
        self.assertEqual((fcl["whole_cycles"], fcl["guaranteed_cycles"], fcl["complete_cycles"]),
                         (FRAMES, 0, 0))
        self.assertEqual((cpu["whole_cycles"], cpu["guaranteed_cycles"], cpu["complete_cycles"]),
                         (FRAMES, FRAMES, FRAMES))
        self.assertIn(f"{FRAMES} of {FRAMES} cycles with nothing left out, but without a guarantee",
                      done.stdout)
        self.assertIn(f"{FRAMES} of {FRAMES} cycles complete", done.stdout)
        for text in done.stdout, self.report():
            self.assertNotIn(f"0 of {FRAMES}", text.replace(f"20 of {FRAMES}", ""))
            self.assertIn("Passed, as nothing was asked", text)
            self.assertIn("fcl guarantees no set of pairs", text)


if __name__ == "__main__":
    main()
