"""The library as others use it: installed, in the devel space, as a subproject."""
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = Path(os.environ["DCM_BINARY_DIR"])
SOURCE = Path(os.environ["DCM_SOURCE_DIR"])
HERE = Path(__file__).resolve().parent
PACKAGE = "deformable_contact_monitor"
WARNINGS = "-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror"
KNOWN_PAIRS = "0 0 1 0\n0 1 1 0\n"
PUBLIC_HEADERS = {
    "core": {
        "backend_choice.h", "backend_error.h", "body_distance.h", "body_path.h", "cpu_detector.h",
        "detector.h", "detector_pool.h", "export.h", "host_device.h", "host_list.h", "limits.h",
        "mesh_file.h", "options.h", "pair_geometry.h", "pair_settings.h", "rigid_transform.h",
        "scene.h", "state_checker.h", "steady_time.h", "substeps.h", "tiling.h", "tiling_cache.h",
        "triangle_mesh.h", "vector3.h"},
    "cuda": {"cuda_detector.h", "cuda_state_checker.h", "detector_choice.h"},
}


def run(*command, **options):
    """Its output; a failure shows all of it."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, **options)
    if done.returncode != 0:
        raise AssertionError("%s\nended with %d:\n%s" % (command, done.returncode, done.stdout))
    return done.stdout


def cached(name):
    """A variable of the build under test."""
    found = re.search("^%s:[A-Z]+=(.*)$" % name, (BUILD / "CMakeCache.txt").read_text(), re.M)
    return found.group(1) if found else ""


WITH_ROS = cached("WITH_ROS").upper() in ("ON", "1", "TRUE", "YES")


if WITH_ROS:  # test/ros/controllers.py uses them
    PUBLIC_HEADERS["reader"] = {"contact_reader.h", "contact_subscriber.h", "monitor_margins.h",
                                "rival_monitors.h"}
LIBRARIES = "core", "cuda"


class OutsideProject(unittest.TestCase):
    """Builds the outside project in a folder of its own."""

    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="outside_test_"))
        cls.addClassCleanup(shutil.rmtree, str(cls.folder))

    @classmethod
    def install(cls, build, name):
        """Installs a build within the folder, and returns where. catkin installs some files into the
        prefix that was configured, whatever --prefix says, so DESTDIR keeps them from there."""
        run(cached("CMAKE_COMMAND"), "--install", build, "--prefix", "/" + name,
            env={**os.environ, "DESTDIR": str(cls.folder)})
        return cls.folder / name

    def build(self, name, library_from, *options):
        """Builds the outside project with this tree's tools, and runs what it made."""
        build = self.folder / name
        run(cached("CMAKE_COMMAND"), "-S", HERE, "-B", build, "-G", cached("CMAKE_GENERATOR"),
            "-DCMAKE_CXX_COMPILER=" + cached("CMAKE_CXX_COMPILER"),
            "-DCMAKE_CXX_COMPILER_LAUNCHER=" + cached("CMAKE_CXX_COMPILER_LAUNCHER"),
            "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DLIBRARY_FROM=%s" % library_from, *options)
        run(cached("CMAKE_COMMAND"), "--build", build, "--", "-j2")
        pairs = subprocess.run([str(build / "use_library")], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, universal_newlines=True, cwd=str(build))
        self.assertEqual((pairs.returncode, pairs.stdout), (0, KNOWN_PAIRS), pairs.stderr)
        mesh = build / "crossing.off"
        mesh.write_text("OFF\n6 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 -1\n1 0 1\n0 1 1\n3 0 1 2\n3 3 4 5\n")
        lines = run(build / "example", mesh, mesh).splitlines()
        self.assertEqual([line for line in lines if line.startswith("cloth")], ["cloth 0 cloth 1"])
        self.assertEqual(len(lines), 5)
        return build


class OutsideTest(OutsideProject):
    """Uses the library installed, in the devel space and as a component of catkin."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.prefix = cls.install(BUILD, "installed")

    def find_package(self, name, prefix, *options):
        return self.build(name, "package", "-DCMAKE_PREFIX_PATH=%s" % prefix,
                          "-DCMAKE_CXX_FLAGS=-O0 " + WARNINGS, *options)

    def test_installed(self):
        """And moved since."""
        moved = self.folder / "moved"
        shutil.copytree(str(self.prefix), str(moved), symlinks=True)
        cache = (self.find_package("by_package", moved) / "CMakeCache.txt").read_text()
        self.assertIn("%s_DIR:PATH=%s" % (PACKAGE, moved), cache)

    @unittest.skipUnless(WITH_ROS, "this build is without ROS")
    def test_devel_space(self):
        devel = cached("CATKIN_DEVEL_PREFIX") or BUILD / "devel"
        self.find_package("by_devel_space", devel, "-DHEADERS_ALONE=OFF")

    @unittest.skipUnless(WITH_ROS, "this build is without ROS")
    def test_component_of_catkin(self):
        self.build("by_catkin", "catkin", "-DCMAKE_PREFIX_PATH=%s" % self.prefix)

    def test_only_public_headers_are_installed(self):
        for name, expected in PUBLIC_HEADERS.items():
            folder = self.prefix / "include" / PACKAGE / name
            self.assertEqual({str(p.relative_to(folder)) for p in folder.rglob("*.*")}, expected)
        folders = {p.name for p in (self.prefix / "include" / PACKAGE).iterdir() if p.is_dir()}
        self.assertEqual(folders, set(PUBLIC_HEADERS))
        include = {p.name for p in (self.prefix / "include").iterdir()}
        self.assertEqual(include, {PACKAGE})

    @unittest.skipUnless(WITH_ROS, "this build is without ROS")
    def test_pages_that_warnings_name_are_installed(self):
        pages = self.prefix / "share" / PACKAGE / "config/docs"
        self.assertTrue((pages / "console.md").is_file())
        self.assertFalse((pages / "Doxyfile").exists())

    def test_names_and_versions_of_the_libraries(self):
        version = re.search(r"VERSION (\d+\.\d+)\.(\d+) ", (SOURCE / "CMakeLists.txt").read_text())
        for name in LIBRARIES:
            library = "lib%s_%s.so" % (PACKAGE, name)
            found = [p for p in self.prefix.rglob(library)]
            self.assertEqual(len(found), 1, library)
            self.assertTrue(Path("%s.%s.%s" % (found[0], version[1], version[2])).is_file())
            dynamic = run("readelf", "-d", found[0])
            self.assertIn("soname: [%s.%s]" % (library, version[1]), dynamic)
            self.assertNotIn(str(BUILD), dynamic)

    def test_what_is_inline_stays_inside(self):
        """Else a copy that the program made, with other flags, would be used by verdicts."""
        core = next(self.prefix.rglob("lib%s_core.so" % PACKAGE))
        names = [line.split(" ", 2)[2] for line in run("nm", "-DC", "--defined-only", core)
                 .splitlines()]
        ours = [name for name in names if name.startswith(PACKAGE)]
        self.assertTrue([name for name in ours if "makeCpuDetector" in name], names)
        inside = r"::(dot|cross|operator[-+*]|apply|posedVertex|orientation\w*|\w*[vV]erdict\w*)\("
        self.assertEqual([name for name in ours if re.search(inside, name)], [])

    def test_the_example_is_the_one_of_the_readme(self):
        self.assertIn((HERE / "example.cpp").read_text(),
                      (SOURCE / "src/core/README.md").read_text())


class SubprojectTest(OutsideProject):
    """Uses the library as a subproject, which compiles all of it again."""

    def test_as_a_subproject(self):
        build = self.build("as_subproject", SOURCE, "-DWITH_CUDA=OFF", "-DBUILD_TESTING=ON",
                           "-DCMAKE_CXX_FLAGS=-O0 -ffast-math " + WARNINGS)
        commands = json.loads((build / "compile_commands.json").read_text())
        theirs = [c["command"] for c in commands if Path(c["file"]).parent == HERE]
        ours = [c for c in commands if Path(c["file"]).parent != HERE]
        self.assertEqual(len(theirs), 2)
        for command in theirs:
            for flag in ("-ffp-contract", "-fno-math-errno", "-fvisibility", " -w ", "-O3",
                         "-DNDEBUG", "-std=c++17", "-fPIC"):
                self.assertNotIn(flag, command)
            self.assertNotIn("-I%s" % SOURCE, command)
        for made in ours:
            self.assertRegex(made["command"], "-ffast-math .*-fno-fast-math.* -ffp-contract=off")
            self.assertIn(SOURCE / ("cuda" if "cuda" in made["file"] else "src/core"),
                          Path(made["file"]).parents)
        self.assertFalse([c for c in ours if "/test/" in c["file"] or "/tools/" in c["file"]])
        self.assertIn("CMAKE_BUILD_TYPE:STRING=\n", (build / "CMakeCache.txt").read_text())
        self.install(build, "nothing")
        self.assertFalse((self.folder / "nothing").exists())


CONTROLLER = """#include <deformable_contact_monitor/reader/contact_subscriber.h>
#include <ros/ros.h>
int main(int argc, char** argv) {
  ros::init(argc, argv, "controller");
  if (argc > 1) return 3;  // the test has no ROS master
  ros::NodeHandle node;
  deformable_contact_monitor::ContactSubscriber contacts(node, "contact_monitor/contact_states", {});
  for (ros::WallRate rate(100); ros::ok() && !contacts.mayMove("hand"); rate.sleep()) ros::spinOnce();
}
"""
# What a build of the messages alone may find: ROS's packages for messages, and those of roscpp.
MAY_BE_FOUND = {
    "catkin", "roscpp", "geometry_msgs", "std_msgs", "message_generation", "message_runtime",
    "genmsg", "gencpp", "geneus", "genlisp", "gennodejs", "genpy",
    "cpp_common", "rosconsole", "roscpp_serialization", "roscpp_traits", "rosgraph_msgs", "rostime",
    "xmlrpcpp", "PythonInterp", "Threads"}
MAY_BE_ASKED_FOR = MAY_BE_FOUND | {"GTest", "GMock", "Python3"}  # catkin does, and goes on without
# Stands before find_package, notes what is asked for, and lets nothing else be found.
ONLY_THESE = """
macro(find_package name)
  file(APPEND ${CMAKE_BINARY_DIR}/asked.txt "${name}\\n")
  if("${name}" MATCHES "^(%s)$")
    _find_package(${name} ${ARGN})
  elseif("${ARGN}" MATCHES "REQUIRED")
    message(FATAL_ERROR "${name} is not there")
  else()
    set(${name}_FOUND FALSE)
  endif()
endmacro()
""" % "|".join(sorted(MAY_BE_FOUND))


class MessagesOnlyTest(unittest.TestCase):
    """Builds and installs the messages and readers where nothing else can be found."""

    def test_a_controller_needs_no_more(self):
        folder = Path(tempfile.mkdtemp(prefix="messages_only_test_"))
        self.addCleanup(shutil.rmtree, str(folder))
        (folder / "only_these.cmake").write_text(ONLY_THESE)
        (folder / "controller.cpp").write_text(CONTROLLER)
        install = folder / "install"
        environment = {name: value for name, value in os.environ.items() if name != "CUDACXX"}
        environment["PATH"] = "/usr/bin:/bin"  # without nvcc
        environment["CMAKE_PREFIX_PATH"] = ":".join(
            path for path in os.environ.get("CMAKE_PREFIX_PATH", "").split(":")
            if not path.startswith(str(BUILD)))

        def build(name, source, *options):
            run(cached("CMAKE_COMMAND"), "-S", source, "-B", folder / name, "-G", cached("CMAKE_GENERATOR"),
                "-DCMAKE_CXX_COMPILER=" + cached("CMAKE_CXX_COMPILER"), *options, env=environment)
            run(cached("CMAKE_COMMAND"), "--build", folder / name, "--", "-j2", env=environment)

        build("messages", SOURCE, "-DMESSAGES_ONLY=ON", "-DCMAKE_INSTALL_PREFIX=%s" % install,
              "-DCMAKE_PROJECT_%s_INCLUDE=%s" % (PACKAGE, folder / "only_these.cmake"))
        asked = set((folder / "messages" / "asked.txt").read_text().split())
        self.assertLessEqual({"catkin", "roscpp"}, asked)
        self.assertEqual(asked - MAY_BE_ASKED_FOR, set())
        self.assertNotIn("CMAKE_CUDA_COMPILER", (folder / "messages" / "CMakeCache.txt").read_text())
        run(cached("CMAKE_COMMAND"), "--install", folder / "messages", env=environment)
        self.assertFalse(list(install.rglob("*.so*")))
        headers = {p.name for p in (install / "include" / PACKAGE).rglob("*.h")}
        self.assertLessEqual(PUBLIC_HEADERS["reader"] | {"ContactStates.h"}, headers)
        share = install / "share" / PACKAGE
        for name in "package.xml", "msg/ContactStates.msg", "msg/from_0_2.bmr", "config/nodelet_plugins.xml":
            self.assertTrue((share / name).is_file(), name)

        build("controller", HERE / "controller", "-DCMAKE_PREFIX_PATH=%s" % install,
              "-DSOURCE=%s" % (folder / "controller.cpp"))
        done = subprocess.run([str(folder / "controller" / "controller"), "x"])
        self.assertEqual(done.returncode, 3)
        packages, = install.rglob("dist-packages")
        environment["PYTHONPATH"] = "%s:%s" % (packages, os.environ.get("PYTHONPATH", ""))
        said = run(sys.executable, "-c", "\n".join((
            "from deformable_contact.contact_reader import ContactReader",
            "from deformable_contact_monitor.msg import ContactStates",
            "import deformable_contact",
            "try: deformable_contact.Scene",
            "except ImportError as error: print(deformable_contact.__file__, error)")), env=environment)
        self.assertTrue(said.startswith(str(packages)), said)
        self.assertIn("is not in a build of the messages alone", said)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
