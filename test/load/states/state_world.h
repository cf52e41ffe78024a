// A small random world for a detection loop: two objects with clocks of their own, some links, the
// transforms that move them, and what may go wrong with all of these. It remembers everything that
// it sent, so that StateJudge can judge states by it.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_buffer.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"
#include "small_shapes.h"

namespace deformable_contact_monitor {

// Random numbers of one seed, the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double from(double low, double high) { return low + (high - low) * (engine_() >> 11U) * 0x1p-53; }
  std::size_t below(std::size_t count) { return engine_() % count; }
  bool chance(double share) { return from(0, 1) < share; }
  template <class Value>
  Value oneOf(const std::vector<Value>& values) {
    return values[below(values.size())];
  }

 private:
  std::mt19937_64 engine_;
};

// Returns random parameters of a monitor of the objects "cloth" and "cable".
MonitorParameters randomParameters(Dice* dice);

// A mesh that was sent. Its vertices are in `frame`.
struct SentMesh {
  std::string frame;
  SmallShape shape;
  std::uint32_t topology = 0;
  bool is_good = true;    // a monitor may use it
  bool was_used = false;  // in some cycle
};

class StateWorld {
 public:
  // `trouble`: how often something goes wrong, from 0 (never) to 1.
  StateWorld(std::uint64_t seed, double trouble, const MonitorParameters& parameters);

  // Lets steady time go on [s], makes what is due by then, and delivers it to `meshes` and
  // `buffer`, unless `holds_transforms`: then transforms wait.
  void advance(double seconds, bool holds_transforms, MeshInputs* meshes, TransformBuffer* buffer);

  // Lets the clock jump [s], or run at another rate.
  void jump(double seconds) { offset_s_ += seconds; }
  void setRate(double rate);
  // Stops one source for some seconds: an object (0, 1) or a moving frame (2 and more).
  void silence(std::size_t source, double seconds);
  std::size_t sourceCount() const { return 2 + frames_.size(); }

  double steadyS() const { return steady_s_; }
  // Returns the steady clock, which is far ahead of the real one: no deadline comes by itself.
  SteadyTime steady() const { return start_ + fromSeconds(steady_s_); }
  ros::Time now() const;
  // Returns the robot as it is now; the other variant has other links.
  std::shared_ptr<const RobotGeometry> robot() const { return robots_[variant_]; }
  void changeRobot() { variant_ = 1 - variant_; }

  // Forgets transforms that the buffer does not have any more. Call it before questions.
  void noteClearedBuffer(TransformBuffer* buffer);

  // Returns the pose of a frame in "base" by the transforms that were delivered; nothing without
  // transforms on both sides of the stamp.
  std::optional<RigidTransform> poseAt(const std::string& frame, const ros::Time& stamp) const;
  // Returns the mesh of that stamp; null if none was delivered.
  SentMesh* mesh(std::size_t object, const ros::Time& stamp);
  // Notes a reset, from which on no mesh may be used that a cycle has used before.
  void noteReset();
  // Returns the shape of a link; null if the robot has none of that name.
  const SmallShape* link(const std::string& name) const;

 private:
  // A motion about a middle, without an end.
  struct Motion {
    Vec3d middle, reach;
    double speeds[3], phases[3];
    Vec3d axis;
    double turn, turn_speed;

    Vec3d place(double time) const;
    double angle(double time) const { return turn * std::sin(turn_speed * time); }
  };
  struct Sample {
    Vec3d place;
    double angle;
  };
  struct Frame {
    std::string name, parent;
    Motion motion;
    double period_s, due_s, silent_until_s;  // period_s 0: it stands still
    std::map<ros::Time, Sample> samples;     // those in the buffer
  };
  struct Object {
    Motion motion;
    std::string frame;
    std::vector<SmallShape> shapes;  // by topology
    double period_s, due_s, silent_until_s;
    std::size_t shape = 0, since_keyframe = 0;
    std::uint32_t topology = 1;
    std::set<ros::Time> stamps;          // of all meshes, also of those underway
    std::map<ros::Time, SentMesh> sent;  // those that were delivered
  };
  struct Delivery {
    double due_s;
    bool is_transform;
    std::function<void()> deliver;
  };

  bool goesWrong(double share) { return trouble_ > 0 && dice_.chance(trouble_ * share); }
  Motion randomMotion(double reach);
  double delay();
  void sendTransform(Frame* frame, TransformBuffer* buffer);
  void putTransform(Frame* frame, const ros::Time& stamp, const Sample& sample,
                    TransformBuffer* buffer);
  void sendMesh(std::size_t object, MeshInputs* meshes);
  SentMesh newMesh(Object* object, DeformableMesh* message);
  bool spoil(DeformableMesh* message, std::string* problem);
  std::optional<Sample> sampleAt(const Frame& frame, const ros::Time& stamp) const;
  std::optional<RigidTransform> edgeAt(const Frame& frame, const ros::Time& stamp) const;

  Dice dice_;
  const double trouble_;
  const SteadyTime start_;
  double steady_s_ = 0, clock_s_ = 1000, rate_ = 1, offset_s_ = 0;
  std::vector<Frame> frames_;
  std::vector<Object> objects_;
  std::vector<Delivery> underway_;
  std::shared_ptr<const RobotGeometry> robots_[2];
  std::map<std::string, SmallShape> links_;
  std::size_t variant_ = 0;
  std::uint32_t topologies_ = 1;
};

}  // namespace deformable_contact_monitor
