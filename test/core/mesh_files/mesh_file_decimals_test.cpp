// Decimal numbers in mesh files become the nearest float32: held against MPFR, bit by bit.
#include <mpfr.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>

#include "mesh_file_fixture.h"

namespace deformable_contact_monitor {
namespace {

// float32 of MPFR: 24 bits, and exponents such that the least subnormal is 2^-149.
class Float32Oracle {
 public:
  Float32Oracle() {
    mpfr_set_emin(-148);
    mpfr_set_emax(128);
    mpfr_init2(value_, 24);
  }
  ~Float32Oracle() {
    mpfr_clear(value_);
    mpfr_set_emin(mpfr_get_emin_min());
    mpfr_set_emax(mpfr_get_emax_max());
  }
  Float32Oracle(const Float32Oracle&) = delete;
  Float32Oracle& operator=(const Float32Oracle&) = delete;

  float operator()(const std::string& text) {
    char* end = nullptr;
    const int rounded = mpfr_strtofr(value_, text.c_str(), &end, 10, MPFR_RNDN);
    EXPECT_EQ(*end, '\0') << text;
    mpfr_subnormalize(value_, rounded, MPFR_RNDN);
    return mpfr_get_flt(value_, MPFR_RNDN);
  }

 private:
  mpfr_t value_;
};

std::string objOf(const std::vector<std::string>& texts) {
  std::string obj;
  for (std::size_t i = 0; i < texts.size(); ++i) obj += (i % 3 == 0 ? "\nv " : " ") + texts[i];
  for (std::size_t i = texts.size(); i % 3 != 0; ++i) obj += " 0";
  return obj + "\nf 1 1 1\n";
}

class MeshFileDecimalsTest : public MeshFileTest {
 protected:
  void expectNearest(const std::vector<std::string>& texts) const {
    const TriangleMesh mesh = read("a.obj", objOf(texts));
    ASSERT_GE(mesh.vertices.size(), texts.size());
    Float32Oracle nearest;
    int wrong = 0;
    for (std::size_t i = 0; i < texts.size() && wrong < 20; ++i) {
      const float wanted = nearest(texts[i]);
      if (bitsOf({mesh.vertices[i]}) == bitsOf({wanted})) continue;
      ++wrong;
      ADD_FAILURE() << texts[i].substr(0, 60) << " was read as " << mesh.vertices[i];
    }
  }
};

std::string exactText(double value) {
  char text[400];
  std::snprintf(text, sizeof text, "%.200f", value);
  return text;
}

TEST_F(MeshFileDecimalsTest, Hard) {
  expectNearest({
      // halfway between two floats, and a hair beyond, where a double in between would be wrong
      "1.000000059604644775390625",
      "1.000000059604644775390625000000000000000000000001",
      "1.00000005960464477539062499999999999999999999999",
      "16777217",
      "16777219",
      "0.1",
      "-0",
      "+0.5",
      ".5",
      "-.5",
      "5.",
      "+1e+5",
      "00000000000000000001.5",
      "1E2",
      // at float's ends
      "3.4028235e38",
      "3.40282356779733661637539395458142568447e38",
      "3.40282356779733661637539395458142568448e38",
      "-3.5e38",
      "1e39",
      "-1e400",
      "1e99999999999999999999999",
      "-1e-99999999999999999999999",
      "0e99999999999999999999999",
      "1.17549435e-38",
      "1.1754943e-38",
      "1.4e-45",
      "7.1e-46",
      "7.0064923216240853e-46",
      "7.0064923216240854e-46",
      "7.006492321624085354618e-46",
      "7.006492321624085354619e-46",
      "-7e-46",
      "1e-400",
      "-1e-400",
      "123456789012345678901234567890123456789012345678901234567890",
      "0." + std::string(300, '0') + "1e300",
      std::string(300, '1') + "e-290",
      "1" + std::string(300, '0') + "e-600",
      "0." + std::string(300, '0') + "1e600",
  });
}

TEST_F(MeshFileDecimalsTest, Random) {
  std::mt19937_64 random(11);
  std::vector<std::string> texts;
  for (int i = 0; i < 200000; ++i) {
    std::string digits = std::to_string(random() >> random() % 50);
    if (i % 4 == 0) digits += std::to_string(random());
    digits.insert(1 + random() % digits.size(), ".");
    const int exponent = static_cast<int>(random() % 120) - 80;
    texts.push_back((i % 2 == 0 ? "-" : "") + digits + "e" + std::to_string(exponent));
  }
  expectNearest(texts);
}

// The exact decimal of a float and half a unit in its last place; every other one a hair beyond.
TEST_F(MeshFileDecimalsTest, Halfway) {
  std::mt19937_64 random(12);
  std::vector<std::string> texts;
  for (int i = 0; i < 60000; ++i) {
    const double halfway = (16777216.0 + 2.0 * static_cast<double>(random() % 8388608) + 1) *
                           std::ldexp(1.0, static_cast<int>(random() % 100) - 75);
    texts.push_back(exactText(halfway) + (i % 2 == 0 ? "" : "1"));
  }
  expectNearest(texts);
}

TEST_F(MeshFileDecimalsTest, Subnormal) {
  std::mt19937_64 random(13);
  std::vector<std::string> texts;
  for (int i = 0; i < 60000; ++i) {
    const double units = static_cast<double>(random() % (1U << 24)) / (i % 2 == 0 ? 2 : 1);
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", std::ldexp(units, -149));
    texts.emplace_back(text);
  }
  expectNearest(texts);
}

TEST_F(MeshFileDecimalsTest, InfinityAndNan) {
  const std::vector<std::string> texts = {"inf", "-inf", "Infinity", "+inf", "INF",
                                          "nan", "-NaN", "nan(7)",   "NAN"};
  const TriangleMesh mesh = read("a.obj", objOf(texts));
  const float infinity = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (i < 5) {
      EXPECT_EQ(mesh.vertices[i], i == 1 ? -infinity : infinity) << texts[i];
    } else {
      EXPECT_TRUE(std::isnan(mesh.vertices[i])) << texts[i];
    }
  }
}

// The numbers are as Windows programs write them. Their '#' begins no comment.
TEST_F(MeshFileDecimalsTest, InfinityAndNanOfWindows) {
  for (const std::string sign : {"", "-", "+"}) {
    for (const char* name :
         {"1.#INF", "1.#inf00", "1.#INF000e+000", "1.#QNAN", "1.#QNAN0", "1.#IND", "1.#IND00",
          "1.#SNAN", "1.#qnan0e+000", "nan(ind)", "nan(snan)"}) {
      const std::string text = sign + name;
      const std::vector<std::pair<std::string, std::string>> files = {
          {"a.obj", "v 0 1 " + text + "\nv 0 0 0 # x\nf 1 2 2\n"},
          {"a.off", "OFF\n2 1 0\n0 1 " + text + "\n0 0 0# x\n3 0 1 1\n"},
          {"a.ply",
           "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
           "end_header\n0 1 " +
               text + "\n0 0 0\n3 0 1 1\n"},
          {"a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 1 " + text +
                        "\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid\n"}};
      for (const auto& [file, content] : files) {
        const float value = read(file, content).vertices[2];
        if (text.find("INF") == std::string::npos && text.find("inf") == std::string::npos) {
          EXPECT_TRUE(std::isnan(value)) << file << " " << text;
        } else {
          EXPECT_TRUE(std::isinf(value) && (value < 0) == (sign == "-")) << file << " " << text;
        }
      }
    }
  }
  EXPECT_EQ(read("a.obj", "v 0 0 1.# a comment\nv 0 0 1.#\nv 0 0 -1.\nf 1 2 3\n").vertices,
            (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, -1}));
  for (const char* text : {"1.#J", "1.#comment", "1.#QNANx", "1.#IN", "1.#infinity"}) {
    const std::string error = errorOf(write("b.obj", objOf({text})));
    EXPECT_NE(error.find("b.obj:2: a coordinate expected, but there is '" + std::string(text)),
              std::string::npos)
        << error;
  }
}

TEST_F(MeshFileDecimalsTest, WhatIsNoDecimalIsRefused) {
  for (const char* text :
       {"0x10", "-0X1p3", "0x",  "1e",    "1e+", "+-1",     "--1",  "++1",    "-",  "+",
        ".",    "-.e1",   "1,5", "1.5.5", "1_0", "infinit", "nan(", "nan(-)", "1f", "e5"}) {
    const std::string error = errorOf(write("a.obj", objOf({text})));
    EXPECT_NE(error.find("a.obj:2: "), std::string::npos) << text;
    EXPECT_NE(error.find("'" + std::string(text) + "'"), std::string::npos) << error;
  }
  const std::string with_nul = errorOf(write("b.obj", objOf({std::string("1\0002", 3)})));
  EXPECT_NE(with_nul.find("'1?2'"), std::string::npos) << with_nul;
}

}  // namespace
}  // namespace deformable_contact_monitor
