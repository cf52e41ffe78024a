"""Plays a monitor, so that a test decides what it sends."""
import threading
import time

import rospy

from deformable_contact_monitor.msg import ContactState, ContactStates
from deformable_contact_monitor.srv import GetContacts, GetContactsResponse

PERIOD_S = 0.05
BODIES = ("palm", "finger", "cloth")


def state(name, pairs=0, reason=""):
    """Of palm and cloth."""
    return ContactState(body_a="palm", body_b="cloth", state=getattr(ContactState, name),
                        pair_count=pairs, reason=reason)


class PlayedMonitor:
    """Sends play(t), t [s] since somebody listened: a ContactState, or None for nothing. Its
    stamp is stamp(now, t)."""

    def __init__(self, name, play, stamp=lambda now, t: now):
        self.name = name
        self.play = play
        self.stamp = stamp
        self.started = None
        self.publisher = rospy.Publisher(name + "/contact_states", ContactStates, queue_size=10)
        self.response = GetContactsResponse(available=True)
        self.response.contacts.bodies = list(BODIES)
        rospy.Service(name + "/get_contacts", GetContacts, lambda request: self.response)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            time.sleep(PERIOD_S)
            if self.publisher.get_num_connections() == 0:
                continue
            self.started = self.started or time.monotonic()
            t = time.monotonic() - self.started
            played = self.play(t)
            if played is None:
                continue
            message = ContactStates(states=[played])
            message.header.stamp = played.stamp = self.stamp(rospy.Time.now(), t)
            self.publisher.publish(message)
