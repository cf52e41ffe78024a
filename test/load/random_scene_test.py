#!/usr/bin/env python3
"""A monitor on a small random scene: links and objects that move, meshes and transforms that get
lost or are invalid, and services that are called at any time. Every state is judged by a truth of
its own: all bodies are made of convex pieces, and two of them overlap unless an axis parts them.

By hand: random_scene_test.py [--seed N] [--minutes M]. Each seed is one scene of 8 s, as far as
threads repeat themselves; random_states does the same with simulated clocks, exactly."""
import argparse
import random
import sys
import threading
import time

import numpy as np

from load_support import FRAME, NAME, Session, scene, wait_until

SECONDS = 8  # of one scene
NONE, NEAR, CONTACT, ALLOWED, UNKNOWN, PASSED = range(6)
ROUNDING_M, PASSING_M = 1e-4, 2e-3
BOX = np.array([[x, y, z] for x in (-.1, .1) for y in (-.1, .1) for z in (-.05, .05)])
SHEETS = {"object_0": 0.5 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0.1], [-1, 1, 0]]),
          "object_1": 0.35 * np.array([[-1, 0, -1], [1, 0, -1], [1, 0.1, 1], [-1, 0, 1]])}
TRIANGLES = [[0, 1, 2], [0, 2, 3]]


def rotations(quaternions):
    """Matrices (n, 3, 3) of unit quaternions (n, 4), x y z w."""
    x, y, z, w = quaternions.T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
                     2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                     2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
                    axis=-1).reshape(-1, 3, 3)


def gaps(a, b):
    """For each of n times, how far two convex pieces are apart along the axis that parts them best
    [m]; negative: how deep they overlap. A piece is vertices (n, v, 3), edges (n, e, 3) and normals
    (n, f, 3)."""
    across = np.cross(a[1][:, :, None], b[1][:, None, :]).reshape(len(a[1]), -1, 3)
    axes = np.concatenate([a[2], b[2], across], axis=1)
    length = np.linalg.norm(axes, axis=2, keepdims=True)
    axes = np.where(length > 1e-9, axes / np.maximum(length, 1e-9), 0)
    on_a, on_b = (np.einsum("nvi,nki->nkv", piece[0], axes) for piece in (a, b))
    apart = np.maximum(on_a.min(2) - on_b.max(2), on_b.min(2) - on_a.max(2))
    return np.where(length[:, :, 0] > 1e-9, apart, -np.inf).max(1)


def box_pieces(places, quaternions):
    turned = rotations(quaternions)
    vertices = np.einsum("nij,vj->nvi", turned, BOX) + places[:, None]
    axes = np.swapaxes(turned, 1, 2)
    return [(vertices, axes, axes)]


def sheet_pieces(vertices):
    pieces = []
    for triangle in TRIANGLES:
        corners = vertices[:, triangle]
        edges = np.roll(corners, -1, axis=1) - corners
        normal = np.cross(edges[:, :1], edges[:, 1:2])
        in_plane = np.cross(normal, edges)
        pieces.append((corners, edges, np.concatenate([normal, in_plane], axis=1)))
    return pieces


class Motion:
    """Of one body: a place and a rotation about one axis."""

    def __init__(self, dice):
        self.reach = np.array([dice.uniform(-.4, .4) for _ in range(3)])
        self.speeds = np.array([dice.uniform(1, 6) for _ in range(3)])
        axis = np.array([dice.uniform(-1, 1) for _ in range(3)]) + [0, 0, 1e-3]
        self.axis = axis / np.linalg.norm(axis)
        self.turn = dice.uniform(-1, 1)

    def at(self, seconds):
        angle = self.turn * np.sin(2 * seconds) / 2
        return (self.reach * np.sin(self.speeds * seconds),
                np.append(self.axis * np.sin(angle), np.cos(angle)))


class World:
    """Sends, and remembers what it sent: transforms by link, vertices by object and stamp [ns]."""

    def __init__(self, seed, links):
        import rospy
        from deformable_contact_monitor.msg import DeformableMesh
        from tf2_msgs.msg import TFMessage
        self.rospy = rospy
        self.dice = random.Random(seed)
        self.motions = {name: Motion(self.dice) for name in links + list(SHEETS)}
        self.periods = {name: self.dice.uniform(0.01, 0.06) for name in self.motions}
        self.samples = {link: [] for link in links}
        self.meshes = {name: {} for name in SHEETS}
        self.tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
        self.publishers = {name: rospy.Publisher("/" + name, DeformableMesh, queue_size=10)
                           for name in SHEETS}
        senders = [self.tf, *self.publishers.values()]
        wait_until(lambda: all(sender.get_num_connections() > 0 for sender in senders),
                   "the monitor")
        self.ended = threading.Event()
        self.threads = [threading.Thread(target=self._send, args=(name, random.Random(seed)),
                                         daemon=True)
                        for name in self.motions]
        for thread in self.threads:
            thread.start()

    def end(self):
        self.ended.set()
        for thread in self.threads:
            thread.join()
        for publisher in [self.tf, *self.publishers.values()]:
            publisher.unregister()

    def _send(self, name, dice):
        count = 0
        while not self.ended.wait(self.periods[name] * dice.uniform(0.8, 1.2)):
            stamp = self.rospy.Time.now()
            place, quaternion = self.motions[name].at(time.monotonic())
            if dice.random() < 0.02:
                time.sleep(dice.uniform(0, 0.7))
            if name in self.samples:
                self._send_transform(name, stamp, place, quaternion)
            else:
                self._send_mesh(name, stamp, place, quaternion, count, dice)
                count += 1

    def _send_transform(self, link, stamp, place, quaternion):
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage
        transform = TransformStamped()
        transform.header.stamp, transform.header.frame_id = stamp, FRAME
        transform.child_frame_id = link
        t, r = transform.transform.translation, transform.transform.rotation
        t.x, t.y, t.z = place
        r.x, r.y, r.z, r.w = quaternion
        self.samples[link].append((stamp.to_nsec(), place, quaternion))
        self.tf.publish(TFMessage([transform]))

    def _send_mesh(self, name, stamp, place, quaternion, count, dice):
        from deformable_contact_monitor.msg import DeformableMesh
        vertices = (SHEETS[name] @ rotations(quaternion[None])[0].T + place).astype(np.float32)
        message = DeformableMesh()
        message.header.stamp, message.header.frame_id = stamp, FRAME
        message.topology_id = 1
        message.vertices = vertices.flatten().tolist()
        message.triangles = np.array(TRIANGLES).flatten().tolist() if count % 8 == 0 else []
        trouble = dice.randrange(60)
        if trouble == 0:
            message.vertices = message.vertices[1:]
        elif trouble == 1:
            message.topology_id = 2
        elif trouble == 2:
            message.vertices[4] = float("nan")
        else:
            self.meshes[name][stamp.to_nsec()] = vertices.astype(float)
        self.publishers[name].publish(message)

    def links_at(self, link, stamps):
        """Places and rotations as tf2 interpolates them; None beyond the transforms."""
        samples = list(self.samples[link])
        known = np.array([sample[0] for sample in samples], dtype=np.int64)
        after = np.searchsorted(known, stamps)
        if len(known) < 2 or after.max() >= len(known) or stamps.min() < known[0]:
            return None
        before = np.maximum(after - 1, 0)
        span = np.maximum(known[after] - known[before], 1)
        part = np.clip((stamps - known[before]) / span, 0, 1)[:, None]
        places, turns = (np.array([sample[i] for sample in samples]) for i in (1, 2))
        cosine = (turns[before] * turns[after]).sum(1, keepdims=True)
        end = np.where(cosine < 0, -turns[after], turns[after])
        angle = np.arccos(np.clip(np.abs(cosine), 0, 1))
        sine = np.sin(angle)
        is_small = sine < 1e-6
        weights = [np.where(is_small, p, np.sin(p * angle) / np.where(is_small, 1, sine))
                   for p in (1 - part, part)]
        turn = weights[0] * turns[before] + weights[1] * end
        turn /= np.linalg.norm(turn, axis=1, keepdims=True)
        return places[before] * (1 - part) + places[after] * part, turn

    def pieces(self, name, begin_ns, end_ns, times):
        """The convex pieces of a body at these times [0, 1] between two stamps; None: not known."""
        if name in self.samples:
            stamps = begin_ns + (times * (end_ns - begin_ns)).astype(np.int64)
            poses = self.links_at(name, stamps)
            return None if poses is None else box_pieces(*poses)
        begin, end = (self.meshes[name].get(ns) for ns in (begin_ns, end_ns))
        if begin is None or end is None:
            return None
        return sheet_pieces(begin[None] + (end - begin)[None] * times[:, None, None])


class Judge:
    """Judges the messages of ~contact_states. `faults` says what was wrong."""

    def __init__(self, world, parameters):
        self.world, self.parameters = world, parameters
        self.lock = threading.Lock()
        self.messages, self.faults, self.answers = [], [], []
        self.before, self.cycle = {}, 0
        self.known = self.states = self.judged = 0

    def store(self, message):
        with self.lock:
            self.messages.append(message)

    def note_answer(self, rospy, is_enabled):
        """To be called before ~set_enabled true is called, and after false was answered."""
        self.answers.append((rospy.Time.now().to_nsec(), is_enabled))

    def judge_all(self):
        with self.lock:
            messages, self.messages = self.messages, []
        for message in messages:
            self.judge(message)

    def judge(self, message):
        joins = message.cycle <= self.cycle + 1  # else messages were lost
        self.cycle = message.cycle
        now = {}
        for state in message.states:
            self.states += 1
            if state.state in (ALLOWED, UNKNOWN):
                continue
            self.known += 1
            pair = (state.body_a, state.body_b)
            stamp = state.stamp.to_nsec()
            now[pair] = (state.state, stamp)
            before = self.before.get(pair)
            if before != now[pair]:
                self.judge_state(state, stamp, before[1] if before and joins else None)
        self.before = now
        if now:  # published then, by the monitor's clock, which is ours
            published = min(stamp for _, stamp in now.values()) + message.age.to_nsec()
            asked = [entry for entry in self.answers if entry[0] < published]
            if asked and not asked[-1][1]:
                late_s = (published - asked[-1][0]) * 1e-9
                self.faults.append(f"{sorted(now)} known {late_s:.3f} s after ~set_enabled false")

    def judge_state(self, state, stamp, before):
        a, b = (self.world.pieces(name, stamp, stamp, np.zeros(1))
                for name in (state.body_a, state.body_b))
        if a is None or b is None:
            return  # the partner has an older mesh
        self.judged += 1
        gap = min(gaps(one, other)[0] for one in a for other in b)
        name = f"{state.body_a}/{state.body_b} at {state.stamp} in state {state.state}"
        if state.state == CONTACT and gap > ROUNDING_M:
            self.faults.append(f"{name}: {gap} m apart")
        if state.state != CONTACT and gap < -ROUNDING_M:
            self.faults.append(f"{name}: they overlap by {-gap} m")
        if state.state == NEAR and gap > self.parameters["margin_m"] + ROUNDING_M:
            self.faults.append(f"{name}: {gap} m apart")
        if self.parameters["motion"] != "swept" or state.state not in (NONE, NEAR) or not before:
            return
        if stamp <= before or state.body_a not in self.world.samples:
            return
        times = np.linspace(0, 1, 40)
        a, b = (self.world.pieces(name, before, stamp, times)
                for name in (state.body_a, state.body_b))
        if a is not None and b is not None:
            gap = min(gaps(one, other).min() for one in a for other in b)
            if gap < -PASSING_M:
                self.faults.append(f"{name}: they overlapped by {-gap} m since {before * 1e-9}")


class Services:
    """Calls one service after another, at random."""

    def __init__(self, world, judge):
        from deformable_contact_monitor.msg import AllowedContact
        from deformable_contact_monitor.srv import (
            AttachObject, GetContacts, SetAllowedContacts)
        from std_srvs.srv import SetBool, Trigger
        proxy = world.rospy.ServiceProxy
        self.world, self.judge, self.rule = world, judge, AllowedContact
        self.enable = proxy(NAME + "/set_enabled", SetBool)
        self.allow = proxy(NAME + "/set_allowed_contacts", SetAllowedContacts)
        self.attach = proxy(NAME + "/attach_object", AttachObject)
        self.others = [proxy(NAME + "/reset", Trigger), proxy(NAME + "/reload_robot", Trigger),
                       proxy(NAME + "/get_contacts", GetContacts)]

    def call(self, dice):
        which = dice.randrange(5)
        if which == 0:
            self.enable(False)
            self.judge.note_answer(self.world.rospy, False)
            time.sleep(dice.uniform(0, 1))
            self.judge.note_answer(self.world.rospy, True)
            self.enable(True)
        elif which == 1:
            rule = self.rule(body_a="link_0", body_b="object_1", allowed=dice.random() < 0.3)
            self.allow(rules=[rule])
        elif which == 2:
            self.attach(object="object_0", links=["link_1"] if dice.random() < 0.3 else [])
        else:
            dice.choice(self.others)()


def run_scene(session, seed):
    """Runs one scene; returns its judge."""
    import rospy
    from deformable_contact_monitor.msg import ContactStates
    dice = random.Random(seed)
    links = ["link_0", "link_1", "link_2"]
    parameters = {"motion": dice.choice(["instant", "swept", "swept"]),
                  "margin_m": dice.choice([0.0, 0.05]),
                  "robot_rate_hz": dice.choice([10, 30, 100]),
                  "pair_classes": ["robot_deformable", "deformable_deformable", "robot_self"]}
    for name, value in scene(len(links), len(SHEETS), **parameters).items():
        session.api.setParam("/test", name, value)
    monitor = session.monitor()
    world = World(seed, links)
    judge = Judge(world, parameters)
    subscriber = rospy.Subscriber(NAME + "/contact_states", ContactStates, judge.store,
                                  tcp_nodelay=True)
    services = Services(world, judge)
    end = time.monotonic() + SECONDS
    while time.monotonic() < end and not judge.faults:
        time.sleep(dice.uniform(0, 0.3))
        services.call(dice)
        judge.judge_all()
    world.end()
    subscriber.unregister()
    if not monitor.runs():
        judge.faults.append("the monitor ended: " + monitor.output())
    monitor.interrupt()
    judge.judge_all()
    return judge


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the first scene")
    parser.add_argument("--minutes", type=float, default=0.3, help="for how long")
    arguments = parser.parse_args()
    end = time.monotonic() + 60 * arguments.minutes
    states = known = judged = seed = failed = 0
    with Session() as session:
        import rospy
        rospy.init_node("random_scene_test", disable_signals=True)
        for seed in range(arguments.seed, sys.maxsize):
            judge = run_scene(session, seed)
            states, known, judged = (
                states + judge.states, known + judge.known, judged + judge.judged)
            for fault in judge.faults[:5]:
                print(f"seed {seed}: {fault}", flush=True)
            failed += bool(judge.faults)
            if time.monotonic() >= end:
                break
    print(f"seeds {arguments.seed} to {seed}: {states} states, {known} known, {judged} judged; "
          f"{failed} seeds with a fault")
    if judged == 0:
        print("nothing was judged")
    return 1 if failed or judged == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
