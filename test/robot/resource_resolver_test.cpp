// Mesh URIs, with a package path of the test's own.
#include <cstdlib>
#include <stdexcept>

#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

class ResourceResolverTest : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh_ = folder_.write("some_robot/meshes/a b.stl", "x");
    folder_.write("some_robot/package.xml",
                  "<package><name>some_robot</name><version>1.0.0</version><description>d"
                  "</description><maintainer email=\"a@b.c\">m</maintainer><license>BSD</license>"
                  "</package>");
    setenv("ROS_PACKAGE_PATH", folder_.path().c_str(), 1);
    setenv("ROS_HOME", (folder_.path() / "home").c_str(), 1);
  }

  std::string failure(const std::string& uri) {
    try {
      resolve_(uri);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  std::string mesh_;
  ResourceResolver resolve_ = makeRosResolver();
};

TEST_F(ResourceResolverTest, ResolvesPackagesFilesAndAbsolutePaths) {
  EXPECT_EQ(resolve_("package://some_robot/meshes/a b.stl"), mesh_);
  EXPECT_EQ(resolve_("package://some_robot/meshes/a%20b.stl"), mesh_);
  EXPECT_EQ(resolve_("file://" + mesh_), mesh_);
  EXPECT_EQ(resolve_("file://localhost" + mesh_), mesh_);
  EXPECT_EQ(resolve_(mesh_), mesh_);
  const std::string percent = folder_.write("100%.stl", "x");
  EXPECT_EQ(resolve_("file://" + percent), percent);
}

TEST_F(ResourceResolverTest, SaysWhatWasLookedForAndWhere) {
  ::testing::internal::CaptureStderr();
  const std::string no_package = failure("package://no_such_robot_anywhere/a.stl");
  EXPECT_NE(no_package.find("'no_such_robot_anywhere' not found"), std::string::npos);
  EXPECT_NE(no_package.find("ROS_PACKAGE_PATH is " + folder_.path().string()), std::string::npos)
      << no_package;
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");

  const std::string no_file = failure("package://some_robot/b.stl");
  EXPECT_NE(no_file.find((folder_.path() / "some_robot/b.stl").string()), std::string::npos);
  EXPECT_NE(failure("file:///no/such.stl").find("/no/such.stl"), std::string::npos);
  EXPECT_NE(failure("/no/such.stl").find("/no/such.stl"), std::string::npos);
}

TEST_F(ResourceResolverTest, RefusesWhatIsNoUriOfAFile) {
  for (const char* uri :
       {"", "meshes/a.stl", "http://host/a.stl", "file://host/a.stl", "file://", "package://",
        "package:///a.stl", "package://-h/a.stl", "package://a b/a.stl",
        "package://some_robot --deps/a.stl", "package://a;b/c", "file:///a%00b"}) {
    EXPECT_NE(failure(uri), "") << uri;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
