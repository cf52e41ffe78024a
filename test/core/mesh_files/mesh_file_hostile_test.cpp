// Tests which files the mesh readers reject and with which message. Also checks that no file makes
// them crash or use too much memory or time.
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>
#include <random>

#include "core/mesh_files/mesh_readers.h"
#include "mesh_file_fixture.h"

namespace {

std::atomic<std::size_t> largest_allocation{0};

}  // namespace

// Not inlined, or the compiler takes malloc and delete for a mismatch.
__attribute__((noinline)) void* operator new(std::size_t size) {
  std::size_t largest = largest_allocation;
  while (size > largest && !largest_allocation.compare_exchange_weak(largest, size)) {
  }
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace deformable_contact_monitor {
namespace {

const std::string kPlyHead =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPlyVertices = "0 0 0\n1 0 0\n0 1 0\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

std::string binaryPly(const std::string& format) {
  std::string text = replaced(kPlyHead, "ascii", format) + std::string(36, '\0') + '\3';
  for (const char index : {0, 1, 2}) {
    text +=
        format == "binary_big_endian" ? std::string(3, '\0') + index : index + std::string(3, '\0');
  }
  return text;
}

std::string binaryStl(std::uint32_t announced, std::size_t bytes, const std::string& title) {
  std::string text = title + std::string(80 - title.size(), '\0');
  text.append(reinterpret_cast<const char*>(&announced), 4);
  return text + std::string(bytes, '\0');
}

std::string cutShort(std::string text) {
  text.pop_back();
  return text;
}

struct Refused {
  const char* name;
  std::string content;
  std::string message;  // after the path
};

std::vector<Refused> refusedFiles() {
  const std::string facet = "facet normal 0 0 1\nouter loop\n";
  return {
      {"a.obj", "", ": is empty"},
      {"a.obj", "v 1 2 3\n", ": holds no triangle"},
      {"a.obj", "v 1 2\nf 1 1 1\n", ":1: a coordinate expected, but the line ends"},
      {"a.obj", "v 1 2", ":1: a coordinate expected, but the file ends"},
      {"a.obj", "v 1 2 3x\n", ":1: a coordinate expected, but there is '3x'"},
      {"a.obj", "v 1 2 \x1b[2J\n", ":1: a coordinate expected, but there is '?[2J'"},
      {"a.obj", "v 1 2 +-3\n", ":1: a coordinate expected, but there is '+-3'"},
      {"a.obj", "v 1 2 3 four\n", ":1: a weight or a colour expected, but there is 'four'"},
      {"a.obj", "v 0 0 0\nf 1 1\n", ":2: a face needs 3 vertices or more, this one has 2"},
      {"a.obj", "v 0 0 0\n\nf 1 1 \\\n 0\n", ":4: vertex index '0' is out of range"},
      {"a.obj", "v 0 0 0\nf 1 1 2\nf 1 1 1\n", ":2: the face refers to vertex 2, but there are 1"},
      {"a.obj", "v 0 0 0\nf -1 -1 -2\n", ":2: vertex index '-2' is out of range"},
      {"a.obj", "v 0 0 0\nf 1 1 99999999999999999999\n", ":2: vertex index '99999999999999999999'"},
      {"a.obj", "v 0 0 0\nf 1 1 9223372036854775807\n", ":2: vertex index '922337"},
      {"a.obj", "v 0 0 0\nf 1 1 1.5\n", ":2: a vertex index expected, but there is '1.5'"},
      {"a.obj", "v 0 0 0\nf 1 1 1\nF 1 1 1\n", ":3: OBJ statements are in lower case"},
      {"a.obj", "v 0 0 0\nf 1 1 1\nV 1 1 1\n", ":3: OBJ statements are in lower case"},
      {"a.obj", "v 0 0 0\nf 1 1 1\ncall b.obj\n", ":3: 'call' is not supported"},
      {"a.obj", "v 0 0 0\nf 1 1 1\nsurf 0 1 0 1 1 1 1 1\n", ":3: 'surf' is not supported"},
      {"a.obj", "v 0 0 0\nf 1 1 1/x\n", ":2: a vertex index expected, but there is '1/x'"},
      {"a.off", "FOO\n", ":1: OFF, COFF, NOFF, CNOFF or STOFF expected, but there is 'FOO'"},
      {"a.off", "OFF BINARY\n", ":1: the number of vertices expected"},
      {"a.off", "OFF\n99999999999 1 0\n", ":2: the number of vertices '99999999999' is out of"},
      {"a.off", "OFF\n2000000000 1 0\n0 0 0\n", ":2: 2000000000 vertices announced"},
      {"a.off", "OFF\n1 2000000000 0\n0 0 0\n", ":3: 2000000000 faces announced"},
      {"a.off", "OFF\n2 1 0\n0 0 0\n         \n", ":5: the file ends after 1 of 2 vertices"},
      {"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", ":4: vertex index '1' is out of range"},
      {"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 -1\n", ":4: vertex index '-1' is out of range"},
      {"a.off", "OFF\n1 1 0\n0 0 0\n2 0 0     \n", ":4: a face needs 3 vertices or more"},
      {"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 0\n3 0 0 0\n", ":5: more lines than the counts"},
      {"a.stl", "solid", ":1: 'facet' or 'endsolid' expected, but the file ends"},
      {"a.stl", "solid a\nendsolid a\n", ": holds no triangle"},
      {"a.stl", "solid a\n" + facet + "vertex 0 0 0\nvertex 0 0 0\nendloop\n",
       ":6: 'vertex' expected, but there is 'endloop'"},
      {"a.stl", "solid a\n" + facet + "vertex 0 0\nvertex", ":4: a coordinate expected"},
      {"a.stl", "solid a\n" + facet + "vertex 0 0 0\n", ":5: 'vertex' expected, but the file ends"},
      {"a.stl", "short", ": neither ascii STL (no 'solid' at its start) nor binary STL"},
      {"a.stl", binaryStl(2, 50, "x"),
       ": binary STL of 2 facets would have 184 bytes, this file "
       "has 134 (count at byte 80)"},
      {"a.stl", binaryStl(0xFFFFFFFF, 50, "solid"), ": binary STL of 4294967295 facets"},
      {"a.stl", binaryStl(0, 0, "x"), ": holds no triangle"},
      {"a.ply", "PLY\n", ":1: 'ply' expected, but there is 'PLY'"},
      {"a.ply", "ply\n", ":2: the header does not end: no 'end_header'"},
      {"a.ply", "ply\nelement vertex 1\nend_header\n", ":3: the header has no 'format' line"},
      {"a.ply", replaced(kPlyHead, "ascii", "ebcdic"), ":2: ascii, binary_little_endian or"},
      {"a.ply", replaced(kPlyHead, "float x", "real x"), ":4: a property type expected"},
      {"a.ply", replaced(kPlyHead, "float x", "float u"),
       ":9: element 'vertex' has no properties x"},
      {"a.ply", replaced(kPlyHead, "float y", "float x"), ":5: element 'vertex' has this property"},
      {"a.ply", replaced(kPlyHead, "float x", "list int int x"), ":4: property 'x' is a list"},
      {"a.ply", replaced(kPlyHead, "list uchar int", "int"), ":8: property 'vertex_indices' is no"},
      {"a.ply", replaced(kPlyHead, "vertex_indices", "corners"), ":9: element 'face' has no list"},
      {"a.ply", replaced(kPlyHead, "face", "vertex"), ":7: element 'vertex' is announced twice"},
      {"a.ply", replaced(kPlyHead, "vertex 3", "vertex -3"), ":3: the number of elements '-3' is"},
      {"a.ply", replaced(kPlyHead, "vertex 3", "vertex 18446744073709551614"),
       ":10: 18446744073709"},
      {"a.ply", replaced(kPlyHead, "face 1", "face 2000000000") + kPlyVertices, ":12: 2000000000"},
      {"a.ply", kPlyHead + "0 0\n0 0 0\n0 0 0\n3 0 1 2\n", ":10: a number expected, but the line"},
      {"a.ply", kPlyHead + "0 0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n", ":10: the end of the line expected"},
      {"a.ply", kPlyHead + kPlyVertices + "3 0 1 3\n", ":13: vertex index '3' is out of range"},
      {"a.ply", kPlyHead + kPlyVertices + "2 0 1\n", ":13: a face needs 3 vertices or more"},
      {"a.ply", kPlyHead + kPlyVertices + "2000000000 0\n",
       ":13: vertex index expected, but the l"},
      {"a.ply", kPlyHead + kPlyVertices + "3 0 1 2\n3 0 1 2\n", ":14: more lines than the header"},
      {"a.ply", kPlyHead + "0 0 0\n0 0 0\n            ", ":12: the file ends amid its elements"},
      {"a.ply", replaced(kPlyHead, "face 1", "face 0") + kPlyVertices, ": holds no triangle"},
      {"a.ply", cutShort(binaryPly("binary_big_endian")), ": the file ends amid its elements (b"},
      {"a.ply", binaryPly("binary_big_endian") + "x",
       ": more bytes than the header announces (byte"},
      {"a.ply", replaced(binaryPly("binary_little_endian"), std::string("\3\0", 2), "\3\7"),
       ": vertex index 7.000000 is out of range, must be in [0, 3) (byte"},
      {"a.ply",
       replaced(replaced(binaryPly("binary_little_endian"), "float z",
                         "float z\nproperty list int int q"),
                std::string("\3\0", 2), "\xff\x7f"),
       ": the file ends amid its elements (byte"},
  };
}

TEST_F(MeshFileTest, BadFilesAreRefusedByNameAndPlace) {
  for (const Refused& refused : refusedFiles()) {
    const std::string file = write(refused.name, refused.content);
    const std::string said = errorOf(file);
    EXPECT_EQ(said.substr(0, file.size() + refused.message.size()), file + refused.message)
        << said << "\nfor: " << refused.content;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
}

std::string wideText(const std::string& text, bool is_big_endian) {
  std::string wide;
  for (const char c : text) {
    wide += is_big_endian ? std::string(1, '\0') + c : c + std::string(1, '\0');
  }
  return wide;
}

// These files lie in the place of a mesh file when something went wrong.
TEST_F(MeshFileTest, FilesOfOtherKindsAreRefusedWithTheirKind) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string lfs = "version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 684\n";
  const std::string zeros(500, '\0');
  const std::vector<std::pair<std::string, std::string>> kinds = {
      {lfs, ": is a Git LFS pointer"},
      {"<!DOCTYPE html>\n<html>v 0 0 0</html>", ": is an HTML page"},
      {"\xEF\xBB\xBF\n <HTML>\nf \n", ": is an HTML page"},
      {"\xFF\xFE" + wideText(obj, false), ": is UTF-16"},
      {"\xFE\xFF" + wideText(obj, true), ": is UTF-16"},
      {wideText(obj, false), ": is UTF-16"},
      {"PK\3\4" + zeros, ": is a zip archive"},
      {"\x1f\x8b" + zeros, ": is a gzip archive"},
      {"BZh91AY" + zeros, ": is a bzip2 archive"},
      {"\xFD\x37zXZ" + zeros, ": is an xz archive"},
      {"\x28\xB5\x2F\xFD" + zeros, ": is a zstd archive"},
      {"7z\xBC\xAF\x27\x1C" + zeros, ": is a 7z archive"},
      {"Rar!\x1A\7" + zeros, ": is a rar archive"},
      {"mesh.obj" + std::string(249, '\0') + "ustar" + zeros, ": is a tar archive"},
      {"", ": is empty"},
      {" \n\r\n", ": holds nothing but blanks"},
      {zeros, ": holds nothing but blanks or zero bytes"}};
  for (const auto& [content, kind] : kinds) {
    for (const char* name : {"a.obj", "a.off", "a.ply", "a.stl"}) {
      const std::string file = write(name, content);
      const std::string said = errorOf(file);
      EXPECT_EQ(said.substr(0, file.size() + kind.size()), file + kind) << said;
    }
  }
  // A mesh may begin as it likes.
  EXPECT_EQ(read("a.stl", binaryStl(1, 50, lfs.substr(0, 60))).triangleCount(), 1U);
  EXPECT_EQ(read("a.obj", lfs + obj).triangleCount(), 1U);
}

TEST_F(MeshFileTest, StlWithBytesBehindItsLastFacet) {
  const std::string facet = binaryStl(1, 50, "x");
  for (const std::string& rest :
       {std::string(7, '\0'), std::string("\n"), std::string(49, 'x'), std::string(1000, '\0')}) {
    MeshFileReport report;
    EXPECT_EQ(readMeshFile(write("a.stl", facet + rest), &report).triangleCount(), 1U);
    ASSERT_EQ(report.notes.size(), 1U);
    EXPECT_EQ(report.notes[0], "binary STL of 1 facets with " + std::to_string(rest.size()) +
                                   " bytes behind its last facet, which are ignored");
    EXPECT_EQ(readMeshFile(path("a.stl")).triangleCount(), 1U);
  }
  // Facets that were not counted must not be left out in silence.
  const std::string said = errorOf(write("a.stl", facet + std::string(50, 'x')));
  EXPECT_NE(said.find(": binary STL of 1 facets (count at byte 80) with 50 bytes behind its last "
                      "facet: the count is wrong, or something else was appended"),
            std::string::npos)
      << said;
}

TEST_F(MeshFileTest, StlKeywordsOfTwoWords) {
  const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
  const std::string two = facet + "vertex 0 1 0\nend loop\nEND Facet\n";
  EXPECT_EQ(read("a.stl", "solid c\n" + two + two + "end solid c\nsolid\n" + two + "endsolid\n")
                .triangleCount(),
            3U);
  EXPECT_EQ(
      read("a.stl", "solid\n" + two + "endsolid\n\x1a" + std::string(9, '\0')).triangleCount(), 1U);
  EXPECT_NE(errorOf(write("a.stl", "solid c\n" + facet + "vertex 0 1 0\nend facet\n"))
                .find(":7: 'loop' expected, but there is 'facet'"),
            std::string::npos);
}

TEST_F(MeshFileTest, WhatIsNoFileIsRefused) {
  EXPECT_EQ(errorOf(path("none.obj")), path("none.obj") + ": No such file or directory");
  std::filesystem::create_directory(path("folder.ply"));
  EXPECT_EQ(errorOf(path("folder.ply")), path("folder.ply") + ": is a directory, not a mesh file");
  ASSERT_EQ(mkfifo(path("pipe.stl").c_str(), 0600), 0);
  EXPECT_EQ(errorOf(path("pipe.stl")), path("pipe.stl") + ": is not a regular file");
  EXPECT_EQ(errorOf(write("a.dae", "<COLLADA/>")).substr(path("a.dae").size(), 24),
            ": cannot tell the format");
}

using Reader = TriangleMesh (*)(const std::string& path, std::string_view content,
                                MeshFileReport* report, MeshGroups* groups);

// Either a valid mesh or an error that begins with the path; memory in proportion to the file, with
// groups as well. Returns whether it was read.
bool expectHarmless(Reader read, const std::string& content) {
  const std::string path = "a file";
  bool is_read = false;
  largest_allocation = 0;
  const auto start = std::chrono::steady_clock::now();
  try {
    MeshFileReport report;
    MeshGroups groups({"hem", "label=1", "part=1"});
    const TriangleMesh mesh = read(path, content, &report, &groups);
    EXPECT_NO_THROW(validate(mesh, path));
    is_read = true;
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, path.size() + 1), path + ":");
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  EXPECT_LT(elapsed.count(), 10) << content;  // [s]; hundreds of bytes take microseconds
  EXPECT_LT(largest_allocation, 64 * content.size() + 4096) << content;
  return is_read;
}

TEST_F(MeshFileTest, DamagedFilesDoNoHarm) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\n";
  const std::vector<std::pair<Reader, std::string>> good = {
      {readObj, "v 0 0 0\nv 1 0 0\nv 0 1 \\\n 0\nf 1/1 2//2 3/3/3 1\nf -1 -2 -3\n"},
      {readObj, "v 0 0 0\nv 1 0 0\nv 0 1 0\ng hem a hem\nf 1 2 3\no hem\nf 1 2 3\ng\nf 3 2 1\n"},
      {readOff, "COFF\n3 2 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n4 0 1 2 0\n"},
      {readStl, "solid a\n" + facet + facet + "endsolid a\n"},
      {readStl, binaryStl(3, 150, "solid a")},
      {readPly, kPlyHead + kPlyVertices + "3 0 1 2\n"},
      {readPly,
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
       "float "
       "z\nproperty int part\nelement face 2\nproperty uchar label\nproperty list uchar int "
       "vertex_indices\nend_header\n0 0 0 1\n1 0 0 1\n0 1 0 1\n1 3 0 1 2\n2 3 2 1 0\n"},
      {readPly, binaryPly("binary_little_endian")},
      {readPly, binaryPly("binary_big_endian")}};
  std::mt19937 random(3);
  for (const auto& [read, content] : good) {
    EXPECT_TRUE(expectHarmless(read, content)) << content;
    for (std::size_t size = 0; size < content.size(); ++size) {
      expectHarmless(read, content.substr(0, size));
    }
    for (int i = 0; i < 10000; ++i) {
      std::string damaged = content;
      for (std::size_t flips = 1 + random() % 4; flips > 0; --flips) {
        char& byte = damaged[random() % damaged.size()];
        // Digits too, as they make counts and indices that still parse.
        byte = static_cast<char>(random() % 2 == 0 ? random() : '0' + random() % 10);
      }
      expectHarmless(read, damaged);
    }
  }
}

TEST_F(MeshFileTest, GarbageDoesNoHarm) {
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) {
    std::string garbage(random() % 3000, '\0');
    for (char& byte : garbage) byte = static_cast<char>(random());
    for (const Reader read : {readObj, readOff, readPly, readStl}) expectHarmless(read, garbage);
    expectHarmless(readPly, kPlyHead + garbage);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
