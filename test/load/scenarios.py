"""Defines the scenarios of load, runs them and judges the result."""
import collections
import sys
import time

from deaf_subscriber import DeafSubscriber
from load_support import NAME, Session, scene, wait_until
from process_figures import ProcessFigures, has_grown

LONGEST_SILENCE_S = 1.5  # states come once a second at least

# Of the diagnostics, from the arrival of a mesh to what is published of it.
TIMES = ("latency [ms]", "latency of states [ms]", "detection [ms]",
         "latency of states without detection [ms]")

# links, objects and parameters of the monitor; how the client loads it.
Scenario = collections.namedtuple("Scenario", "links objects parameters client deaf")
SCENARIOS = {
    # 215^2 x 2 = 92 450 triangles each
    "heavy": Scenario(10, 10, {"pair_classes": ["robot_deformable", "deformable_self"]},
                      {"rate": 30, "cells": 215}, 0),
    "one": Scenario(1, 1, {"pair_classes": ["robot_deformable", "deformable_self"]},
                    {"rate": 30, "cells": 215}, 0),
    "fast": Scenario(1, 1, {"max_rate_hz": 0}, {"rate": 500, "cells": 10}, 0),
    "many": Scenario(100, 100, {}, {"rate": 10, "cells": 10}, 0),
    "deaf": Scenario(4, 4, {}, {"rate": 30, "cells": 50}, 4),
}


class Diagnostics:
    """The newest values of the monitor's diagnostics."""

    def __init__(self):
        import rospy
        from diagnostic_msgs.msg import DiagnosticArray
        self.values = {}
        self.subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, self._store)

    def _store(self, message):
        for status in message.status:
            name = status.name.split(": ")[-1]
            self.values[name] = {value.key: value.value for value in status.values}

    def total(self, key):
        """Over all objects."""
        return sum(int(values.get(key, 0)) for name, values in list(self.values.items())
                   if name.startswith("mesh:"))

    def cycles(self):
        return int(self.values.get("status", {}).get("cycles", 0))


def connect_deaf(session, count):
    """As many of each of the monitor's topics, and one each that says nothing at all."""
    from deformable_contact_monitor.msg import ContactArray, ContactEvent, ContactStates, LinkMeshes
    from visualization_msgs.msg import MarkerArray
    api = session.node_api()
    topics = {"contacts": ContactArray, "contact_states": ContactStates, "markers": MarkerArray,
              "contact_events": ContactEvent, "robot_meshes": LinkMeshes}
    return [DeafSubscriber(api, f"{NAME}/{topic}", kind, f"/deaf_{i}", mute=i == count)
            for topic, kind in topics.items() for i in range(count + 1)]


def run_scenario(name, seconds, devel, parameters, client_options, say=print):
    """Loads a monitor of its own; figures, and what of them breaks a promise."""
    scenario = SCENARIOS[name]
    tree = scene(scenario.links, scenario.objects, **scenario.parameters, **parameters)
    pace = {"warm-up": min(5, seconds / 5), "period": min(5, seconds / 8)}
    with Session(devel, tree) as session:
        import rospy
        rospy.init_node("load", anonymous=True, disable_signals=True)
        diagnostics = Diagnostics()
        monitor = session.monitor()
        client = session.client(objects=scenario.objects, links=scenario.links, **pace,
                                **client_options, **scenario.client)
        deaf = connect_deaf(session, scenario.deaf) if scenario.deaf else []
        wait_until(lambda: client.lines or not client.runs(), "the load")
        if not client.runs():
            sys.exit("the load ended: " + client.output())
        figures = watch(monitor, client, diagnostics, seconds, say)
        figures["deaf_still_connected"] = sum(one.is_connected() for one in deaf)
        if monitor.runs():
            end_s, code = monitor.interrupt()
            figures.update(end_after_sigint_s=round(end_s, 2), exit_code=code)
        for one in deaf:
            one.close()
        figures["log_tail"] = monitor.output()[-2000:]
    figures.update(scenario=name, backend=diagnostics.values.get("status", {}).get("backend"),
                   backend_asked_for=parameters["backend"])
    return figures, problems(figures)


def watch(monitor, client, diagnostics, seconds, say):
    process = ProcessFigures(monitor.pid)
    start, cycles_before = time.monotonic(), diagnostics.cycles()
    said = 0
    while time.monotonic() - start < seconds and monitor.runs() and client.runs():
        time.sleep(min(1, seconds / 10))
        if monitor.runs():
            process.look()
        for line in client.lines[said:]:
            say(progress(line, process, diagnostics))
        said = len(client.lines)
    alive = monitor.runs()
    passed_s = time.monotonic() - start
    cycles_hz = (diagnostics.cycles() - cycles_before) / passed_s
    cpu = process.cpu_share() if alive else float("nan")
    time.sleep(1.2)  # diagnostics come once a second
    summary = client.finish()
    unknown = summary.pop("unknown_share", {})
    return {"seconds": round(passed_s, 1), "alive": alive, "client": summary,
            "received": diagnostics.total("received"), "dropped": diagnostics.total("dropped"),
            "refused": diagnostics.total("refused"), "cycles_hz": round(cycles_hz, 1),
            "cpu_share": round(cpu, 2), "memory_mib": process.memory(),
            "timing": diagnostics.values.get("timing", {}),
            "unknown_mean": sum(unknown.values()) / max(1, len(unknown)),
            "unknown_worst": max(unknown.values(), default=1.0)}


def progress(line, process, diagnostics):
    return (f"{line['seconds']:6.0f} s  sent {line['sent']}  states {line.get('messages')}  "
            f"p50 {line.get('p50_ms', 0):.1f} ms  p99 {line.get('p99_ms', 0):.1f} ms  "
            f"silence {line.get('longest_silence_s', 0):.2f} s  dropped "
            f"{diagnostics.total('dropped')}  memory {process.memory_mib[-1]:.0f} MiB")


def problems(figures):
    """What breaks a promise; empty if all is well."""
    found = []
    if not figures["alive"]:
        found.append("the monitor died: " + figures["log_tail"])
    elif figures.get("exit_code") != 0:
        found.append(f"the monitor ended with exit code {figures.get('exit_code')}")
    if figures["backend"] != figures["backend_asked_for"]:
        found.append(f"contacts were found by {figures['backend']}")
    if figures["client"]["longest_silence_s"] > LONGEST_SILENCE_S:
        found.append(f"contact_states was silent for {figures['client']['longest_silence_s']:.2f} s")
    if has_grown(figures["memory_mib"]):
        found.append(f"memory has grown: {figures['memory_mib']}")
    return found
