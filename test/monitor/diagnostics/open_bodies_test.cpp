// Which bodies are said not to be closed, and how often.
#include "monitor/diagnostics/open_bodies.h"

#include <gtest/gtest.h>

#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

using Lines = std::vector<std::string>;

TEST(OpenBodiesTest, AreSaidOnceAndListedWhileTheyAre) {
  SampleReport sample;
  Containment containment;
  containment.bodies = {{true, 1, 0}, {true, 3, 2}, {true, 1, 1}};
  sample.report.containment = &containment;
  OpenBodies bodies;
  EXPECT_EQ(bodies.look(sample.report),
            (Lines{"containment: 2 of 3 parts of 'base' are not closed: nothing is said to be "
                   "within those",
                   "containment: 1 of 1 parts of 'cloth' are not closed: nothing is said to be "
                   "within those"}));
  EXPECT_EQ(bodies.list(), "base (2 of 3 parts), cloth (1 of 1 parts)");
  containment.bodies = {{true, 1, 0}, {false, 0, 0}, {true, 1, 0}};
  EXPECT_EQ(bodies.look(sample.report), Lines());
  EXPECT_EQ(bodies.list(), "base (2 of 3 parts)") << "it was not looked at";
  containment.bodies[2].open = 1;
  EXPECT_EQ(bodies.look(sample.report), Lines()) << "it was said";
  EXPECT_EQ(bodies.list(), "base (2 of 3 parts), cloth (1 of 1 parts)");
}

}  // namespace
}  // namespace deformable_contact_monitor
