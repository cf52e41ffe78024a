#!/usr/bin/env python3
"""What contact_test makes of its parameters and of messages, without a ROS master."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import types
import unittest

import rospy
from deformable_contact_monitor.msg import ContactState, ContactStates

from deformable_contact import _contact_judge

sys.dont_write_bytecode = True  # beside the tool
TOOL = pathlib.Path(__file__).resolve().parents[3] / "src/tools/contact_test/contact_test"


def load_tool():
    """The script as a module."""
    loader = importlib.machinery.SourceFileLoader("contact_test", str(TOOL))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


contact_test = load_tool()
NONE, NEAR, CONTACT = ContactState.NONE, ContactState.NEAR, ContactState.CONTACT
ALLOWED, UNKNOWN = ContactState.ALLOWED, ContactState.UNKNOWN
PASSED = ContactState.PASSED
PAIR = {"link": "palm", "object": "cloth"}
T0 = 1000  # [s]; stamps below are multiples of 1/4 s, which are exact


def message(stamp_s, state, pairs=0, bodies=("palm", "cloth"), header_s=None):
    """Of that pair, and of another that must not matter."""
    stamp = rospy.Time.from_sec(stamp_s)
    header = stamp if header_s is None else rospy.Time.from_sec(header_s)
    return ContactStates(
        header=types.SimpleNamespace(stamp=header),
        states=[ContactState(body_a="finger", body_b="cloth", state=CONTACT, pair_count=99,
                             stamp=rospy.Time(7)),
                ContactState(body_a=bodies[0], body_b=bodies[1], state=state, pair_count=pairs,
                             stamp=stamp)])


def near_message(stamp_s, distance_m, state=None, tolerance_m=0.0):
    """NEAR at that distance, NONE at an infinite one; or of that state."""
    made = message(stamp_s, state if state is not None else NEAR if distance_m < 9e9 else NONE)
    made.states[1].min_separation, made.tolerance = distance_m, tolerance_m
    if tolerance_m == 0 and distance_m > 0 and distance_m < 9e9:
        made.states[1].distance_low = 0.999999 * distance_m
    return made


def judge_distances(wanted, distances, tolerance_m=0.0):
    """After messages every 1/4 s; distances [m], or a state."""
    judge = contact_test.Judge(contact_test.parse({**PAIR, **wanted}))
    for step, seen in enumerate(distances):
        if not judge.passed and not judge.failure:
            is_distance = isinstance(seen, float)
            judge.take(near_message(T0 + step / 4, seen if is_distance else float("nan"),
                                    None if is_distance else seen, tolerance_m), 0.0)
    return judge


def judge(wanted, states, age_s=0.0):
    """After messages every 1/4 s; states: (state, pairs) or a state."""
    judge = contact_test.Judge(contact_test.parse({**PAIR, **wanted}))
    for step, seen in enumerate(states):
        if not judge.passed and not judge.failure:
            seen = seen if isinstance(seen, tuple) else (seen, 0)
            judge.take(message(T0 + step / 4, *seen), age_s)
    return judge


class Parts(unittest.TestCase):
    """A cloth's own state leaves out its named part, whose vertices may be unknown."""

    def judge(self, wanted, part_state, body="cloth:hem", state=NONE):
        judge = contact_test.Judge(contact_test.parse({**PAIR, "hold_s": 1.0, **wanted}))
        for step in range(8):
            made = near_message(T0 + step / 4, float("inf"), state)
            made.states.append(ContactState(body_a=body, body_b="palm", state=part_state,
                                            reason="no vertex", stamp=made.states[1].stamp))
            if not judge.passed and not judge.failure:
                judge.take(made, 0.0)
        return judge

    def test_an_unknown_part_is_neither_none_nor_near_nor_kept(self):
        for wanted, state in (({"state": "none"}, NONE), ({"state": "near"}, NEAR),
                              ({"keeps_m": 0.05}, NONE)):
            judge = self.judge(wanted, UNKNOWN, state=state)
            self.assertFalse(judge.passed, wanted)
            self.assertEqual(judge.state.state, UNKNOWN)
            self.assertTrue(self.judge(wanted, NONE, state=state).passed, wanted)

    def test_other_parts_and_a_certain_contact_count_as_before(self):
        self.assertTrue(self.judge({"state": "none"}, ALLOWED).passed)
        self.assertTrue(self.judge({"state": "none"}, UNKNOWN, body="clothes:hem").passed)
        self.assertTrue(self.judge({"state": "contact"}, UNKNOWN, state=CONTACT).passed)


class Parameters(unittest.TestCase):

    def test_defaults(self):
        wanted = contact_test.parse({**PAIR, "state": "none"})
        self.assertEqual((wanted.monitor, wanted.within_s, wanted.hold_s, wanted.wait_s),
                         ("contact_monitor", 10, 0, 20))
        contact_test.parse({**PAIR, "state": "contact", "min_pairs": 0, "max_pairs": 7, "hold_s": 3,
                            "within_s": 0, "max_age_s": 0.1, "wait_s": 5, "monitor": "/a/b"})

    def test_a_number_with_an_exponent_may_be_a_text(self):
        """PyYAML, and so roslaunch, reads it so."""
        wanted = contact_test.parse({**PAIR, "state": "none", "hold_s": "1e-1", "wait_s": "2.5E1"})
        self.assertEqual((wanted.hold_s, wanted.wait_s), (0.1, 25))

    def test_all_that_is_wrong_is_named_at_once(self):
        bad = {"link": 7, "object": "", "state": "touching", "min_pairs": -1, "max_pairs": 1.5,
               "within_s": "soon", "hold_s": float("nan"), "max_age_s": 0, "wait_s": True,
               "monitor": "no name", "hold": 2}
        with self.assertRaises(ValueError) as refused:
            contact_test.parse(bad)
        for name in bad:
            self.assertRegex(str(refused.exception), rf"(^|; ){name} (must|is)")
        with self.assertRaisesRegex(ValueError, r"^state must be a name, not \['none'\]$"):
            contact_test.parse({**PAIR, "state": ["none"]})
        with self.assertRaisesRegex(ValueError, "link is not set; object is not set; state is not"):
            contact_test.parse({})

    def test_what_no_monitor_can_meet_is_refused(self):
        with self.assertRaisesRegex(ValueError, "max_pairs 2 is less than min_pairs 3"):
            contact_test.parse({**PAIR, "state": "contact", "min_pairs": 3, "max_pairs": 2})
        for state in ("passed", "contact"):
            with self.assertRaisesRegex(ValueError, "max_pairs must not be 0"):
                contact_test.parse({**PAIR, "state": state, "max_pairs": 0})
        contact_test.parse({**PAIR, "state": "near", "max_pairs": 0})  # without near_pairs
        for state in ("none", "allowed", "unknown"):
            with self.assertRaisesRegex(ValueError, "min_pairs must be 0"):
                contact_test.parse({**PAIR, "state": state, "min_pairs": 1})


class Distances(unittest.TestCase):

    INF = float("inf")

    def test_the_distance_must_be_kept_from_the_first_state_on(self):
        wanted = {"keeps_m": 0.25, "hold_s": 0.5}
        self.assertTrue(judge_distances(wanted, [0.5, self.INF, 0.25]).passed)
        verdict = judge_distances(wanted, [0.5, 0.125, 0.5])
        self.assertRegex(verdict.failure, "^not kept: palm and cloth keep 0.25 m, but near at 0.125 m "
                                          "at 1000.250; seen in 2 .* least distance 0.125 m")
        self.assertEqual(judge_distances(wanted, [0.5, 0.5]).passed, False)  # not yet

    def test_what_is_not_known_is_not_kept(self):
        for state in UNKNOWN, ALLOWED:
            self.assertRegex(judge_distances({"keeps_m": 0.3, "hold_s": 9}, [0.5, state]).failure,
                             "^not kept: .* but (unknown|allowed) at 1000.250")
        for state in CONTACT, PASSED:
            self.assertRegex(judge_distances({"keeps_m": 0.3, "hold_s": 9}, [0.5, state]).failure,
                             "^not kept: .* but (contact|passed) at 0 m at 1000.250")
        self.assertEqual(judge_distances({"keeps_m": 0.3}, [UNKNOWN] * 9).failure, "")  # no start

    def test_a_distance_is_certain_within_the_tolerance_alone(self):
        self.assertTrue(judge_distances({"keeps_m": 0.25}, [0.5], tolerance_m=0.25).passed)
        self.assertRegex(judge_distances({"keeps_m": 0.25}, [0.5], tolerance_m=0.375).failure,
                         "^not kept: .* near at 0.125 m")

    def test_distances_are_float32(self):
        nearest = 0.699999988079071  # the float32 nearest to 0.7
        self.assertTrue(judge_distances({"keeps_m": 0.7}, [nearest]).passed)

    def test_parameters(self):
        for more, words in (({"state": "none"}, "state is set, which excludes keeps_m"),
                            ({"min_pairs": 2}, "min_pairs is set, which"),
                            ({"within_s": 2}, "within_s is set, which"),
                            ({"object": "palm"}, "no distance from itself"),
                            ({"object": "palm:pad"}, "no distance from itself"),
                            ({"keeps_m": 0}, "keeps_m must be a number"),
                            ({"keeps_m": "far"}, "keeps_m must be a number")):
            with self.assertRaisesRegex(ValueError, words):
                contact_test.parse({**PAIR, "keeps_m": 0.5, **more})


class Verdicts(unittest.TestCase):

    def passes(self, wanted, *states, **options):
        verdict = judge(wanted, states, **options)
        self.assertTrue(verdict.passed, verdict.failure)
        self.assertEqual(verdict.failure, "")
        return verdict

    def fails(self, wanted, *states, **options):
        verdict = judge(wanted, states, **options)
        self.assertFalse(verdict.passed)
        return verdict.failure

    def test_every_state_is_itself_alone(self):
        for name, value in (("none", NONE), ("near", NEAR), ("contact", CONTACT),
                            ("allowed", ALLOWED), ("unknown", UNKNOWN), ("passed", PASSED)):
            self.passes({"state": name}, value)
            for other in {NONE, NEAR, CONTACT, ALLOWED, PASSED} - {value}:
                self.assertRegex(self.fails({"state": name, "within_s": 0}, other), "^wrong state:")

    def test_unknown_is_never_no_contact(self):
        self.assertEqual(self.fails({"state": "none"}, *[UNKNOWN] * 100), "")  # has not begun
        self.assertRegex(self.fails({"state": "none", "hold_s": 1}, NONE, NONE, UNKNOWN),
                         "^not held: .* until it was unknown with 0 pairs at 1000.500")
        self.assertRegex(self.fails({"state": "near", "within_s": 0.5}, NONE, UNKNOWN, UNKNOWN),
                         "^wrong state: .*: unknown 2, none 1;")

    def test_bodies_in_either_order_or_one_with_itself(self):
        for link, other, bodies in (("cloth", "palm", ("palm", "cloth")),
                                    ("cloth", "cloth", ("cloth", "cloth"))):
            wanted = contact_test.parse({"link": link, "object": other, "state": "near"})
            verdict = contact_test.Judge(wanted)
            verdict.take(message(T0, CONTACT, bodies=("cloth", "other")), 0)
            self.assertIsNone(verdict.started_s)
            verdict.take(message(T0, NEAR, bodies=bodies), 0)
            self.assertTrue(verdict.passed)

    def test_within_s_counts_from_the_first_known_state(self):
        wanted = {"state": "contact", "within_s": 0.5}
        self.passes(wanted, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, NONE, NONE, CONTACT)
        self.assertRegex(self.fails(wanted, UNKNOWN, NONE, NONE, NONE, CONTACT),
                         "^wrong state: not palm and cloth in state contact within 0.5 s; seen in "
                         "3 messages from 1000.250 to 1000.750: none 3; 0 to 0 pairs")

    def test_a_state_that_comes_after_within_s_is_too_late(self):
        self.assertRegex(self.fails({"state": "contact", "within_s": 0.3}, NONE, NONE, CONTACT),
                         "^too late: .* in state contact within 0.3 s; .* last contact")

    def test_hold_s_has_no_gap(self):
        wanted = {"state": "contact", "hold_s": 0.75}
        self.assertEqual(self.fails(wanted, NONE, CONTACT, CONTACT, CONTACT), "")  # not over yet
        self.passes(wanted, NONE, CONTACT, CONTACT, CONTACT, CONTACT)
        self.assertRegex(self.fails(wanted, CONTACT, CONTACT, CONTACT, NEAR, CONTACT),
                         "^not held: .* since 1000.000, for 0.750 of 0.75 s, until it was near")

    def test_pairs(self):
        wanted = {"state": "contact", "min_pairs": 3, "max_pairs": 5, "within_s": 0.5}
        for pairs in (3, 5):
            self.passes(wanted, (CONTACT, 1), (CONTACT, 9), (CONTACT, pairs))
        self.assertRegex(self.fails(wanted, (CONTACT, 9), (CONTACT, 6), (CONTACT, 2)),
                         "^too few pairs: .* at least 3 pairs, at most 5 pairs .* 2 to 9 pairs")
        self.assertRegex(self.fails(wanted, (CONTACT, 1), (CONTACT, 6), NONE), "^too many pairs: ")
        self.assertRegex(self.fails({**wanted, "hold_s": 1}, (CONTACT, 3), (CONTACT, 6)),
                         "^not held: .* until it was contact with 6 pairs")

    def test_age(self):
        wanted = {"state": "none", "hold_s": 0.5, "max_age_s": 0.2}
        self.passes(wanted, NONE, NONE, NONE, age_s=0.2)
        self.assertRegex(self.fails(wanted, NONE, NONE, NONE, age_s=0.3),
                         "^too old: palm and cloth in state none, but 3 messages came more than "
                         "max_age_s 0.2 after their stamp; .*greatest age 0.300 s")

    def test_a_pair_that_is_gone_is_not_there(self):
        verdict = contact_test.Judge(contact_test.parse({**PAIR, "state": "none", "hold_s": 1}))
        verdict.take(message(T0, NONE), 0)
        verdict.take(message(T0 + 0.25, NONE, bodies=("fist", "cloth")), 0)
        self.assertRegex(verdict.failure, "^not held: .* until it was not listed")

    def test_the_pairs_own_stamps_count_whatever_the_messages_are_stamped(self):
        """Of an object whose clock is 5 s behind that of another one, which has cycles too."""
        verdict = contact_test.Judge(contact_test.parse(
            {**PAIR, "state": "contact", "within_s": 1, "hold_s": 0.5, "max_age_s": 5.2}))
        for stamp_s, state in ((T0, NONE), (T0 + 0.25, CONTACT), (T0 + 0.5, CONTACT)):
            verdict.take(message(stamp_s, state, header_s=stamp_s), 5.1)
            for _ in range(3):  # cycles of the other one, and the monitor's own beats
                verdict.take(message(stamp_s, state, header_s=stamp_s + 5), 0.1)
            self.assertEqual((verdict.passed, verdict.failure), (False, ""))
        self.assertEqual(len(verdict.seen), 3)
        verdict.take(message(T0 + 0.75, CONTACT, header_s=T0 + 0.75), 5.1)
        self.assertTrue(verdict.passed, verdict.failure)
        self.assertAlmostEqual(max(verdict.ages_s), 5.1)

    def test_a_state_that_changes_at_its_stamp_is_news(self):
        """A contact between two stamps is found later, and several meshes may share a stamp."""
        for state in (PASSED, CONTACT):
            verdict = contact_test.Judge(contact_test.parse({**PAIR, "state": "none", "hold_s": 1}))
            verdict.take(message(T0, NONE), 0)
            verdict.take(message(T0 + 0.5, NONE), 0)
            verdict.take(message(T0 + 0.5, NONE), 2)  # the same again, which is not old
            self.assertEqual((verdict.failure, max(verdict.ages_s)), ("", 0))
            verdict.take(message(T0 + 0.5, state, pairs=3), 0)
            self.assertRegex(verdict.failure, "^not held: ")

    def test_what_becomes_unknown_is_stamped_by_the_clock_and_is_no_time_jump(self):
        for wanted, pattern in (({"state": "none", "hold_s": 2}, "^not held: .* until it was unknown"),
                                ({"state": "near", "within_s": 1}, "^wrong state: .*unknown 2")):
            verdict = contact_test.Judge(contact_test.parse({**PAIR, **wanted}))
            verdict.take(message(T0, NONE, header_s=T0 + 9), 0)
            for step in range(1, 4):
                if not verdict.failure:
                    verdict.take(message(T0 + 9 + step / 2, UNKNOWN), 0)
            self.assertRegex(verdict.failure, pattern)

    def test_stamps_of_several_meshes_interleave_but_time_does_not_jump(self):
        for jump_to_s in (T0 - 5, T0 + 7):
            verdict = contact_test.Judge(contact_test.parse({**PAIR, "state": "none", "hold_s": 6}))
            for stamp_s in (T0, T0 - 1, T0 + 1, T0 - 2):
                verdict.take(message(stamp_s, NONE), 0)
                self.assertEqual(verdict.failure, "")
            verdict.take(message(jump_to_s, NONE), 0)
            self.assertRegex(verdict.failure,
                             f"^time jump: stamps went from 1001.000 to {jump_to_s}.000")
            self.assertFalse(verdict.passed)


    def test_meshes_may_come_as_seldom_as_the_monitor_allows(self):
        self.assertEqual(_contact_judge.time_jump_s({}), 5)
        self.assertEqual(_contact_judge.time_jump_s({"max_mesh_age_s": 12.0}), 13)
        verdict = contact_test.Judge(contact_test.parse({**PAIR, "state": "none", "hold_s": 12}))
        verdict.time_jump_s = 13
        for stamp_s in (T0, T0 + 6, T0 + 12):
            verdict.take(message(stamp_s, NONE), 0)
        self.assertTrue(verdict.passed)

    def test_a_state_with_an_older_stamp_holds_from_the_newest_one_on(self):
        for before_s, before in ((T0 + 4, NONE), (T0 + 4, UNKNOWN)):
            verdict = contact_test.Judge(
                contact_test.parse({**PAIR, "state": "contact", "hold_s": 2}))
            verdict.take(message(T0, NONE), 0)
            verdict.take(message(before_s, before), 0)
            for quarters in range(4, 25):  # the clock went back, or a mesh came late
                verdict.take(message(T0 + quarters / 4, CONTACT, 1), 0)
                self.assertEqual(verdict.passed, quarters >= 24, quarters)


class Settings(unittest.TestCase):

    def check(self, parameters, wanted, expected):
        found = _contact_judge.settings_problem(contact_test.parse({**PAIR, **wanted}), parameters)
        self.assertRegex(found, expected if expected else r"\A\Z")

    def test_a_margin_below_the_distance_proves_nothing(self):
        self.check({"margin_m": 0.2}, {"keeps_m": 0.25}, "^margin too small: .* of 0.2 m")
        self.check({"margin_m": 0.25}, {"keeps_m": 0.25}, "")
        self.check({"margin_m": 0.7}, {"keeps_m": 0.7}, "")  # both are float32

    def test_no_distance_is_known_within_a_body(self):
        parameters = {"margin_m": 1, "objects": [{"name": "cloth"}, {"name": "left:rope"}]}
        for link, other, is_within in (("cloth:hem", "cloth:logo", True),
                                       ("left:hand", "left:tool", False),
                                       ("left:hand", "left:rope", False),
                                       ("cloth2", "cloth:hem", False)):
            self.check(parameters, {"link": link, "object": other, "keeps_m": 0.5},
                       "no distance from itself" if is_within else "")

    def test_near_pairs_are_no_contacts(self):
        for state, pairs, problem in (("contact", 2, "^pairs not counted: min_pairs .*near_pairs"),
                                      ("contact", 1, ""), ("near", 2, "")):
            wanted = {"state": state, "min_pairs": pairs}
            self.check({"near_pairs": True, "margin_m": 0.1}, wanted, problem)
            self.check({"near_pairs": True}, wanted, "")
            self.check({"near_pairs": False, "margin_m": 0.1}, wanted, "")

    def test_pairs_that_were_not_found_do_not_count(self):
        for name in ("budget_ms", "tolerance_m"):
            self.check({name: 0.5}, {"state": "contact", "max_pairs": 3},
                       f"^pairs not counted: max_pairs .*{name}")
            self.check({name: 0.5}, {"state": "contact", "min_pairs": 3}, "")
            self.check({name: 0}, {"state": "contact", "max_pairs": 3}, "")
            self.check({name: "fast"}, {"state": "contact", "max_pairs": 3}, "")


class Reasons(unittest.TestCase):
    """In the monitor's words: src/monitor/input/mesh_input.cpp, transform_lookup.cpp, monitor_scene.cpp."""

    def test_each_has_its_phrase(self):
        for reason, phrase in (
                ("no mesh yet", "mesh missing"),
                ("mesh refused: header.stamp is zero", "mesh refused"),
                ("newest mesh is 2.0 s old", "mesh stale"), ("no new mesh", "mesh stale"),
                ("no mesh as old as this cycle", "mesh stale"),
                ("TF frame 'palm' never seen", "TF missing"),
                ("TF from 'palm' to 'base' never seen", "TF missing"),
                ("TF from 'palm' to 'base' is late: wanted 3, newest available 2", "TF late"),
                ("TF from 'palm' to 'base' is late: wanted 3, none available yet", "TF late"),
                ("TF from 'palm' to 'base' no longer reaches back: wanted 1", "TF late"),
                ("disabled", "monitor disabled"),
                ("12 of 12 triangles have a vertex that is not finite", "mesh incomplete"),
                ("left: 3 of 9 triangles have a vertex that is not finite", "mesh incomplete"),
                ("marker 'cloth'/0 was deleted", "mesh deleted"),
                ("cannot read lost.stl: TF frame never seen", "body unusable")):
            state = ContactState(body_a="palm", body_b="cloth", reason=f"palm: {reason}")
            self.assertEqual(contact_test.why_unknown(state), (phrase, f"palm: {reason}"))

    def test_of_no_body(self):
        for reason, phrase in (("no new mesh within max_mesh_age_s", "mesh stale"),
                               ("busy: a cycle has been running for 2 s", "monitor busy"),
                               ("not looked at yet", "monitor reset"), ("", "state unknown"),
                               ("robot changed", "monitor reset"), ("strange", "state unknown"),
                               ("in the step: no time", "monitor too slow"),
                               ("not decided in time", "monitor too slow"),
                               ("detection failed: no memory", "detection failed"),
                               ("contacts were left out: memory_limit_mib", "memory limit"),
                               ("the cycle ended later than max_mesh_age_s after its stamp",
                                "monitor too slow")):
            state = ContactState(body_a="palm", body_b="cloth", reason=reason)
            self.assertEqual(contact_test.why_unknown(state)[0], phrase)


if __name__ == "__main__":
    unittest.main()
