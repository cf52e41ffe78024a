// When the program read_link_mesh is missing, dies, hangs or talks nonsense. Shell scripts stand
// in.
#include "robot/reader_process.h"

#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "robot/link_mesh_files.h"
#include "robot/mesh_stream.h"
#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

const std::string kFile = "/folder/link.stl";

class ReaderProcess : public ::testing::Test {
 protected:
  // The reader is this script.
  MeshReading scripted(const std::string& script) const {
    MeshReading reading;
    reading.program = folder_.write("reader", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(reading.program, std::filesystem::perms::owner_all);
    return reading;
  }

  // The reader writes these bytes, and then does what the script says.
  MeshReading writing(const std::string& bytes, const std::string& then = "") const {
    return scripted("cat '" + folder_.write("bytes", bytes) + "'\n" + then);
  }

  const TemporaryFolder folder_;
};

template <typename T>
std::string bytesOf(const T& value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string failure(const MeshReading& reading) {
  try {
    readLinkMeshFile(kFile, reading);
  } catch (const std::runtime_error& e) {
    const std::string what = e.what();
    EXPECT_EQ(what.find(kFile + ": "), 0U) << what;
    return what.substr(std::min(what.size(), kFile.size() + 2));
  }
  return "";
}

std::string header(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t refusal_bytes) {
  MeshStreamHeader header;
  header.vertices = vertices;
  header.triangles = triangles;
  header.refusal_bytes = refusal_bytes;
  return bytesOf(header);
}

std::string threeVertices() {
  return bytesOf(StreamVertex(0, 0, 0)) + bytesOf(StreamVertex(1, 0, 0)) +
         bytesOf(StreamVertex(0, 1, 0.5));
}

std::string robotOf(const std::vector<std::string>& files) {
  std::string collisions;
  for (const std::string& file : files) {
    collisions += "<collision><geometry><mesh filename=\"" + file + "\"/></geometry></collision>";
  }
  return oneLinkUrdf(collisions);
}

RobotGeometry load(const std::string& urdf, const MeshReading& reading) {
  return loadRobotGeometry(
      urdf, {}, [](const std::string& uri) { return uri; }, reading);
}

double secondsSince(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

TEST_F(ReaderProcess, ThisInstallationsIsFound) {
  const std::string program = findReaderProgram();
  EXPECT_EQ(std::filesystem::path(program).filename(), "read_link_mesh");
  EXPECT_TRUE(std::filesystem::exists(program));
}

TEST_F(ReaderProcess, MissingOrNoProgram) {
  MeshReading reading;
  reading.program = "/nowhere/read_link_mesh";
  EXPECT_EQ(failure(reading),
            "/nowhere/read_link_mesh, which would read it, cannot be started: No such file or "
            "directory");
  reading.program = folder_.write("text", "no program");
  EXPECT_NE(failure(reading).find("cannot be started: Permission denied"), std::string::npos);
  // In a robot it is a problem of the links that have files.
  const RobotGeometry robot = load(robotOf({"/a.stl"}), reading);
  EXPECT_NE(robot.links.at(0).problem.find("cannot be started"), std::string::npos);
}

TEST_F(ReaderProcess, AMeshIsReadAsItIsWritten) {
  const StreamTriangle triangle{2, 0, 1};
  const std::string bytes = header(3, 1, 0) + threeVertices() + bytesOf(triangle);
  // All was said: how it ends then is its own affair.
  for (const char* then : {"", "exit 3", "cat /dev/zero", "sleep 1000"}) {
    const auto start = steady_clock::now();
    const SourceMesh mesh = readLinkMeshFile(kFile, writing(bytes, then));
    EXPECT_LT(secondsSince(start), 10) << then;
    ASSERT_EQ(mesh.vertices.size(), 3U);
    EXPECT_EQ(mesh.vertices[2], StreamVertex(0, 1, 0.5));
    EXPECT_EQ(mesh.triangles, std::vector<StreamTriangle>{triangle});
  }
}

TEST_F(ReaderProcess, TheFilesNameIsItsOneArgument) {
  const std::string name = "/a b';\n\xff.stl";
  const MeshReading reading = scripted("printf '%s|' \"$@\" >\"$0\".arguments");
  EXPECT_THROW(readLinkMeshFile(name, reading), std::runtime_error);
  EXPECT_EQ(readText(reading.program + ".arguments"), name + "|");
}

TEST_F(ReaderProcess, ARefusalIsPassedOn) {
  const std::string text = "because";
  EXPECT_EQ(failure(writing(header(0, 0, text.size()) + text)), text);
}

TEST_F(ReaderProcess, OneThatEndsEarlyIsSaid) {
  EXPECT_EQ(failure(scripted("exit 0")), "its reader ended with code 0 and gave no answer");
  EXPECT_EQ(failure(scripted("exit 127")), "its reader ended with code 127 and gave no answer");
  EXPECT_EQ(failure(scripted("kill -9 $$")), "its reader was killed (signal 9, Killed)");
  EXPECT_EQ(failure(scripted("kill -SEGV $$")),
            "its reader crashed (signal 11, Segmentation fault)");
  EXPECT_EQ(failure(scripted("kill -XCPU $$")), "takes more than 20 s of the processor to read");
  EXPECT_EQ(failure(writing(header(3, 1, 0) + threeVertices(), "kill -9 $$")),
            "its reader was killed (signal 9, Killed)");
}

TEST_F(ReaderProcess, AnAnswerThatIsNone) {
  EXPECT_EQ(failure(scripted("cat /dev/zero")),
            "its reader's answer is none: is it of another version?");
  EXPECT_EQ(failure(writing(header(3, 1, 0) + threeVertices() + bytesOf(StreamTriangle{0, 1, 3}))),
            "its reader's answer has a vertex index out of range");
}

// The memory for it would be asked for at once.
TEST_F(ReaderProcess, AnAnswerThatIsTooLarge) {
  const std::string too_large = "more than 256 MiB of vertices and triangles";
  const std::uint64_t max = ~std::uint64_t{0};
  for (const std::string& start :
       {header(max, 1, 0), header(1, max, 0), header(max / 24 + 1, max / 12 + 1, 0),
        header(11'184'811, 0, 0), header(0, 22'369'622, 0), header(5'592'406, 11'184'811, 0),
        header(0, 0, max), header(0, 0, 4097)}) {
    EXPECT_EQ(failure(writing(start, "cat /dev/zero")), too_large);
  }
}

TEST_F(ReaderProcess, OneThatHangsIsEndedInTime) {
  for (const char* script :
       {"sleep 1000", "trap '' INT TERM; while :; do :; done", "exec >&-; sleep 1000"}) {
    MeshReading reading = scripted("echo $$ >\"$0\".process\n" + std::string(script));
    reading.file_time = milliseconds(300);
    const auto start = steady_clock::now();
    const std::string what = failure(reading);
    EXPECT_TRUE(what == "takes longer than 0.3 s to read" || what == "its reader gave no answer")
        << what;
    EXPECT_LT(secondsSince(start), 10);
    const int process = std::stoi(readText(reading.program + ".process"));
    EXPECT_NE(kill(process, 0), 0) << script << " runs on";
  }
}

// Returns a COLLADA file of large polygons, which takes several seconds to read.
std::string slowCollada() {
  constexpr int kCorners = 19'000, kFaces = 200;
  std::string vertices, face, faces, sizes;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 6.283 * i / kCorners, radius = 1 + 0.3 * (i % 2);
    vertices += std::to_string(radius * std::cos(angle)) + " " +
                std::to_string(radius * std::sin(angle)) + " 0 ";
    face += std::to_string(i) + " ";
  }
  for (int i = 0; i < kFaces; ++i) {
    faces += face;
    sizes += std::to_string(kCorners) + " ";
  }
  return "<?xml version=\"1.0\"?><COLLADA "
         "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset/>"
         "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"q\" "
         "count=\"57000\">" +
         vertices +
         "</float_array><technique_common><accessor source=\"#q\" count=\"19000\" stride=\"3\">"
         "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
         "type=\"float\"/></accessor></technique_common></source><vertices id=\"v\"><input "
         "semantic=\"POSITION\" source=\"#p\"/></vertices><polylist count=\"200\"><input "
         "semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><vcount>" +
         sizes + "</vcount><p>" + faces +
         "</p></polylist></mesh></geometry></library_geometries><library_visual_scenes>"
         "<visual_scene id=\"s\"><node><instance_geometry url=\"#g\"/></node></visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

TEST_F(ReaderProcess, AFileThatTakesTooLong) {
  MeshReading reading;
  reading.file_time = milliseconds(1500);
  const std::string slow = folder_.write("slow.dae", slowCollada());
  const std::string good = folder_.write("good.obj", "v 0 0 0\nv 1 0 0\nv 0 2 3\nf 1 2 3\n");
  const auto start = steady_clock::now();
  const std::string problem = load(robotOf({slow, good}), reading).links.at(0).problem;
  EXPECT_LT(secondsSince(start), 15);
  EXPECT_EQ(problem, "link 'l': " + slow + ": " + slow + ": takes longer than 1.5 s to read");
}

TEST_F(ReaderProcess, WhatDripsIsEndedInTimeToo) {
  MeshReading reading = scripted("while :; do printf dcmmesh2; sleep 0.01; done");
  reading.file_time = milliseconds(300);
  EXPECT_NE(failure(reading), "");
}

TEST_F(ReaderProcess, AStopEndsItSoon) {
  MeshReading reading = scripted("sleep 1000");
  std::atomic<bool> is_stopped{false};
  reading.stop = [&] { return is_stopped.load(); };
  std::thread stopper([&] {
    std::this_thread::sleep_for(milliseconds(200));
    is_stopped = true;
  });
  std::vector<std::string> files;
  for (int i = 0; i < 50; ++i) files.push_back("/" + std::to_string(i) + ".stl");
  const auto start = steady_clock::now();
  EXPECT_THROW(load(robotOf(files), reading), ReadingStopped);
  EXPECT_LT(secondsSince(start), 5);
  stopper.join();
}

TEST_F(ReaderProcess, ManyThatHangTakeBoundedTime) {
  MeshReading reading = scripted("sleep 1000");
  reading.file_time = milliseconds(200);
  reading.robot_time = milliseconds(500);
  std::vector<std::string> files;
  for (int i = 0; i < 200; ++i) files.push_back("/" + std::to_string(i) + ".stl");
  const auto start = steady_clock::now();
  const std::string problem = load(robotOf(files), reading).links.at(0).problem;
  EXPECT_LT(secondsSince(start), 10);
  EXPECT_NE(problem.find("takes longer than 0.2 s to read"), std::string::npos);
  EXPECT_NE(problem.find("not read, for the robot's files took 0.5 s"), std::string::npos);
}

TEST_F(ReaderProcess, ManyMeshesTakeBoundedMemory) {
  MeshReading reading =
      writing(header(30'000, 1, 0),
              "head -c 720000 /dev/zero; printf '\\0\\0\\0\\0\\1\\0\\0\\0\\2\\0\\0\\0'");
  reading.robot_mib = 1;
  EXPECT_EQ(load(robotOf({"/a.stl"}), reading).links.at(0).problem, "");
  const std::string problem = load(robotOf({"/a.stl", "/b.stl"}), reading).links.at(0).problem;
  EXPECT_NE(problem.find(".stl: left out, for the robot's meshes take more than 1 MiB"),
            std::string::npos)
      << problem;
}

TEST_F(ReaderProcess, EachFileIsReadOnce) {
  const MeshReading reading = scripted("echo \"$1\" >>\"$0\".files; exit 1");
  load(robotOf({"/a.stl", "/b.stl", "/a.stl", "/b.stl", "/a.stl"}), reading);
  const std::string files = readText(reading.program + ".files");
  EXPECT_TRUE(files == "/a.stl\n/b.stl\n" || files == "/b.stl\n/a.stl\n") << files;
}

// As in roscpp, which ignores SIGPIPE, and in programs that ignore their children.
TEST_F(ReaderProcess, SignalsOfThisProcessAreNotItsOwn) {
  const auto old_pipe = signal(SIGPIPE, SIG_IGN);
  const auto old_child = signal(SIGCHLD, SIG_IGN);
  const StreamTriangle triangle{2, 0, 1};
  const std::string bytes = header(3, 1, 0) + threeVertices() + bytesOf(triangle);
  EXPECT_EQ(readLinkMeshFile(kFile, writing(bytes)).triangles.size(), 1U);
  EXPECT_EQ(failure(scripted("exit 1")), "its reader gave no answer");
  signal(SIGCHLD, old_child);
  EXPECT_EQ(failure(scripted("kill -PIPE $$")), "its reader crashed (signal 13, Broken pipe)");
  signal(SIGPIPE, old_pipe);
}

}  // namespace
}  // namespace deformable_contact_monitor
