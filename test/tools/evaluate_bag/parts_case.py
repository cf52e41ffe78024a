"""evaluate_bag in parts: a recording of the Panda, and how its parts are written and joined."""
from evaluation_case import EvaluationCase
from monitor_test_support import transform_message
from panda_bag import PERIOD, START

EXPECT = """
- {link: panda_hand, object: tshirt, touches: sometime}
- {link: panda_hand, object: tshirt, touches: always, to_s: 0.2}
- {link: panda_link0, object: tshirt, touches: never}
"""
SWEPT = "motion: swept\n"


def frame_of(message):
    return round((message.header.stamp - START).to_sec() / PERIOD.to_sec())


class PartsCase(EvaluationCase):

    def setUp(self):
        super().setUp()
        self.expect = self.text("expect.yaml", EXPECT)

    def write_parts(self, count, arguments):
        files = []
        for number in range(1, count + 1):
            files.append(self.path(f"{number}-of-{count}.records"))
            done = self.tool(*arguments, "--part", f"{number}/{count}", "--records", files[-1])
            self.assertEqual(done.returncode, 0, done.stderr)
        return files

    def arguments(self, config, *bags):
        self.config_file = self.text("config.yaml", config)
        return [*(bags or [self.bag()]), "--config", self.config_file, "--expect", self.expect,
                "--no-report", "--pairs"]

    def touching(self, frames):
        """The scene in which the shirt is away from the arm in all other frames."""
        events = []
        for received, topic, message in self.events:
            if topic == "/tf":
                frame = frame_of(message.transforms[0])
                edges = self.scene.panda.edges_at(frame, (.35, .05, .5 if frame in frames else 2.5))
                message = transform_message(message.transforms[0].header.stamp, edges)
            events.append((received, topic, message))
        return events
