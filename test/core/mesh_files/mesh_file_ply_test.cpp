// PLY in every format and type, with what a mesh does not need in between.
#include <algorithm>
#include <cstdio>
#include <limits>

#include "mesh_file_fixture.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kFormats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
constexpr const char* kIntegers[] = {"char",   "int8",   "uchar", "uint8", "short", "int16",
                                     "ushort", "uint16", "int",   "int32", "uint",  "uint32"};

// Writes a file value by value.
class PlyWriter {
 public:
  PlyWriter(std::string format, const std::string& declarations)
      : format_(std::move(format)),
        text_("ply\nformat " + format_ + " 1.0\ncomment made by a test\n" + declarations +
              "end_header\n") {}

  PlyWriter& put(const std::string& type, double value) {
    if (format_ == "ascii") {
      char text[900];
      std::snprintf(text, sizeof text, "%.800g ", value);  // all digits of the double
      text_ += text;
    } else if (type == "double" || type == "float64") {
      append(value);
    } else if (type == "float" || type == "float32") {
      append(static_cast<float>(value));
    } else if (type == "char" || type == "int8") {
      append(static_cast<std::int8_t>(value));
    } else if (type == "uchar" || type == "uint8") {
      append(static_cast<std::uint8_t>(value));
    } else if (type == "short" || type == "int16") {
      append(static_cast<std::int16_t>(value));
    } else if (type == "ushort" || type == "uint16") {
      append(static_cast<std::uint16_t>(value));
    } else if (type == "int" || type == "int32") {
      append(static_cast<std::int32_t>(value));
    } else {
      append(static_cast<std::uint32_t>(value));
    }
    return *this;
  }

  void endRecord() {
    if (format_ == "ascii") text_ += "\n";
  }

  const std::string& text() const { return text_; }

 private:
  template <typename T>
  void append(T value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (format_ == "binary_big_endian") std::reverse(bytes, bytes + sizeof value);
    text_.append(bytes, sizeof value);
  }

  std::string format_, text_;
};

const std::vector<double> kCoordinates = {
    0.1, -0.2, 1e-40, 1 + 1.0 / 16777216, 1 + 1.0 / 16777215, 3.4028235e38, -0.0, 16777217, 1e-46};

void putVertices(PlyWriter& writer, const std::string& type) {
  for (std::size_t i = 0; i < kCoordinates.size(); ++i) {
    writer.put(type, kCoordinates[i]);
    if (i % 3 == 2) writer.endRecord();
  }
}

std::vector<float> nearestFloats(const std::vector<double>& values) {
  std::vector<float> floats;
  for (const double value : values) floats.push_back(static_cast<float>(value));
  return floats;
}

TEST_F(MeshFileTest, PlyOfEveryIntegerType) {
  for (const std::string format : kFormats) {
    for (const std::string count_type : kIntegers) {
      for (const std::string index_type : kIntegers) {
        PlyWriter writer(format,
                         "element vertex 3\nproperty float x\nproperty float y\n"
                         "property float z\nelement face 2\nproperty list " +
                             count_type + " " + index_type + " vertex_indices\n");
        putVertices(writer, "float");
        writer.put(count_type, 3).put(index_type, 2).put(index_type, 1).put(index_type, 0);
        writer.endRecord();
        writer.put(count_type, 4).put(index_type, 0).put(index_type, 1).put(index_type, 2);
        writer.put(index_type, 1).endRecord();
        const TriangleMesh mesh = read("a.ply", writer.text());
        ASSERT_EQ(bitsOf(mesh.vertices), bitsOf(nearestFloats(kCoordinates)));
        ASSERT_EQ(mesh.triangles, (std::vector<std::uint32_t>{2, 1, 0, 0, 1, 2, 0, 2, 1}))
            << format << " " << count_type << " " << index_type;
      }
    }
  }
}

TEST_F(MeshFileTest, PlyCoordinatesOfEveryIntegerType) {
  const std::vector<std::pair<std::string, std::vector<double>>> extremes = {
      {"char", {-128, 127, -1}},
      {"uchar", {0, 255, 128}},
      {"short", {-32768, 32767, -1}},
      {"ushort", {0, 65535, 32768}},
      {"int", {-2147483648.0, 2147483647, -16777217}},
      {"uint", {0, 4294967295, 2147483649}}};
  for (const std::string format : kFormats) {
    for (const auto& [type, values] : extremes) {
      PlyWriter writer(format, "element vertex 1\nproperty " + type + " x\nproperty " + type +
                                   " y\nproperty " + type +
                                   " z\nelement face 1\nproperty list uchar int vertex_index\n");
      writer.put(type, values[0]).put(type, values[1]).put(type, values[2]).endRecord();
      writer.put("uchar", 3).put("int", 0).put("int", 0).put("int", 0).endRecord();
      EXPECT_EQ(read("a.ply", writer.text()).vertices, nearestFloats(values)) << format << type;
    }
  }
}

// Rounded once: in ascii from the text, in binary from the double.
TEST_F(MeshFileTest, PlyOfDoubles) {
  const double huge = std::numeric_limits<double>::max();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string format : kFormats) {
    for (const std::string type : {"double", "float64"}) {
      PlyWriter writer(format, "element vertex 5\nproperty " + type + " x\nproperty " + type +
                                   " y\nproperty " + type +
                                   " z\nelement face 1\nproperty list uchar int vertex_index\n");
      putVertices(writer, type);
      writer.put(type, huge).put(type, -huge).put(type, 3.5e38).endRecord();
      writer.put(type, nan).put(type, -1e-300).put(type, 1.0 / 3).endRecord();
      writer.put("uchar", 3).put("int", 0).put("int", 1).put("int", 4).endRecord();
      std::vector<double> wanted = kCoordinates;
      wanted.insert(wanted.end(), {huge, -huge, 3.5e38, nan, -1e-300, 1.0 / 3});
      EXPECT_EQ(bitsOf(read("a.ply", writer.text()).vertices), bitsOf(nearestFloats(wanted)))
          << format << " " << type;
    }
  }
}

// Faces first, unknown elements, scalars and lists everywhere, coordinates out of order and of
// integer and mixed types.
TEST_F(MeshFileTest, PlySkipsWhatAMeshDoesNotNeed) {
  for (const std::string format : kFormats) {
    PlyWriter writer(format,
                     "obj_info of no use\n"
                     "element camera 2\nproperty list ushort double view\nproperty char id\n"
                     "element face 2\nproperty uchar red\nproperty list uchar uint vertex_indices\n"
                     "property list int float texcoord\n"
                     "element empty 0\n"
                     "element vertex 4\nproperty short z\nproperty list uint8 int16 ring\n"
                     "property double x\nproperty uint32 flags\nproperty uint y\n"
                     "element edge 1\nproperty int vertex1\nproperty int vertex2\n");
    for (int i = 0; i < 2; ++i) {
      writer.put("ushort", 2 * i);
      for (int j = 0; j < 2 * i; ++j) writer.put("double", 0.5);
      writer.put("char", -7).endRecord();
    }
    writer.put("uchar", 255).put("uchar", 3).put("uint", 3).put("uint", 2).put("uint", 1);
    writer.put("int", 0).endRecord();
    writer.put("uchar", 0).put("uchar", 4).put("uint", 0).put("uint", 1).put("uint", 2);
    writer.put("uint", 3).put("int", 2).put("float", 0.5).put("float", 0.25).endRecord();
    for (int v = 0; v < 4; ++v) {
      writer.put("short", -30000 + v).put("uint8", v);
      for (int j = 0; j < v; ++j) writer.put("int16", -1);
      writer.put("double", 0.1 * v).put("uint32", 9).put("uint", 4294967295.0 - v).endRecord();
    }
    writer.put("int", 0).put("int", 1).endRecord();

    std::vector<double> wanted;
    for (int v = 0; v < 4; ++v)
      wanted.insert(wanted.end(), {0.1 * v, 4294967295.0 - v, -30000.0 + v});
    const TriangleMesh mesh = read("a.ply", writer.text());
    EXPECT_EQ(bitsOf(mesh.vertices), bitsOf(nearestFloats(wanted))) << format;
    EXPECT_EQ(mesh.triangles, (std::vector<std::uint32_t>{3, 2, 1, 0, 1, 2, 0, 2, 3})) << format;
  }
}

TEST_F(MeshFileTest, PlyWithCarriageReturns) {
  const std::string text =
      "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\n"
      "property float z\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\n"
      "end_header\r\n0 0 0\r\n1 0 0\r\n\r\n0 1 0\r\n3 0 1 2";
  EXPECT_EQ(read("a.ply", text).vertices, (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}));
}

// Strips as OpenGL has them: every second triangle is turned round, and -1 begins another strip.
TEST_F(MeshFileTest, PlyTriangleStrips) {
  for (const std::string format : kFormats) {
    for (const std::string type : {"char", "short", "int", "int32"}) {
      PlyWriter writer(format,
                       "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                       "element tristrips 3\nproperty int id\nproperty list int " +
                           type + " vertex_indices\nelement face 1\n" +
                           "property list uchar int vertex_index\n");
      putVertices(writer, "float");
      const auto putStrip = [&](const std::vector<int>& indices) {
        writer.put("int", 7).put("int", static_cast<double>(indices.size()));
        for (const int index : indices) writer.put(type, index);
        writer.endRecord();
      };
      // The strip restarts three times, also for what is too short; 1 1 and 2 2 lead on without a
      // triangle of their own.
      putStrip({0, 1, 2, 0, 1, -1, -1, 2, 1, 0, -1, 0, 1, -1});
      putStrip({0, 1, 2, 2, 1, 1, 0, 2});
      putStrip({});
      writer.put("uchar", 3).put("int", 2).put("int", 1).put("int", 0).endRecord();
      EXPECT_EQ(read("a.ply", writer.text()).triangles,
                (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 0, 2, 0, 1, 2, 1,
                                            0, 0, 1, 2, 0, 1, 2, 2, 1, 0}))
          << format << " " << type;
    }
  }
}

TEST_F(MeshFileTest, BadPlyTriangleStrips) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n"
      "0 1 0\n";
  const std::vector<std::pair<std::string, std::string>> files = {
      {"3 0 1 3", ":13: vertex index '3' is out of range"},
      {"3 0 1 -2", ":13: vertex index '-2' is out of range"},
      {"4 0 1 2", ":13: vertex index expected, but the line ends"},
      {"3 -1 -1 -1", ": holds no triangle"}};
  for (const auto& [strip, message] : files) {
    const std::string said = errorOf(write("a.ply", head + strip + "\n"));
    EXPECT_NE(said.find("a.ply" + message), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
