"""Every contact between deforming triangle meshes, exact, on GPU or CPU.

Scene holds bodies, Detector finds the contacts of its enabled pairs, Result lists them; StateChecker
tells what would touch if bodies stood elsewhere, and Robot, in builds with ROS, where the links of a
URDF would be; read_mesh reads a file. deformable_contact.messages turns this package's ROS messages
into numpy arrays and back. What a contact is: the README of deformable_contact_monitor.
"""
import importlib

__all__ = ["BodyDistance", "Detector", "NearestPair", "Result", "Scene", "StateChecker",
           "StateResults", "__version__", "read_mesh"]


_WITH_ROS = ["Robot"]  # not in __all__, because `import *` must work without it


def __getattr__(name):
    # At first use: whoever reads messages alone does not load the detector.
    if name not in __all__ + _WITH_ROS:
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    try:
        core = importlib.import_module("._core", __name__)
    except ModuleNotFoundError as error:
        if error.name != __name__ + "._core":
            raise
        raise ImportError("%s.%s is not in a build of the messages alone, nor in one without pybind11"
                          % (__name__, name)) from None
    if name in _WITH_ROS and not hasattr(core, name):
        raise AttributeError("%s.%s needs a build with ROS, which finds and reads the files of a "
                             "URDF" % (__name__, name))
    value = getattr(core, name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(set(globals()) | set(__all__ + _WITH_ROS))
