"""Every contact between deforming triangle meshes, exact, on GPU or CPU.

Scene holds bodies, Detector finds the contacts of its enabled pairs, Result lists them; StateChecker
tells what would touch if bodies stood elsewhere; read_mesh reads a file. deformable_contact.messages turns this package's ROS messages into numpy arrays and
back. What a contact is: the README of deformable_contact_monitor.
"""
import importlib

__all__ = ["BodyDistance", "Detector", "NearestPair", "Result", "Scene", "StateChecker",
           "StateResults", "__version__", "read_mesh"]


def __getattr__(name):
    # At first use: whoever reads messages alone does not load the detector.
    if name not in __all__:
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    value = getattr(importlib.import_module("._core", __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(set(globals()) | set(__all__))
