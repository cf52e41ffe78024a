// A small random world for a detection loop.
#include "state_world.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

const char* const kSentinel = "sentinel";  // a frame that shows whether the buffer was cleared
constexpr double kKeptS = 10;              // tf2 keeps transforms for so long

// A closed, convex shape.
SmallShape tetrahedron(double size) {
  return {{{size, size, size}, {size, -size, -size}, {-size, size, -size}, {-size, -size, size}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

SmallShape octahedron(double size) {
  return {{{size, 0, 0}, {-size, 0, 0}, {0, size, 0}, {0, -size, 0}, {0, 0, size}, {0, 0, -size}},
          {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

// An open sheet, cut along one diagonal or the other, or from its middle.
std::vector<SmallShape> sheets(double size) {
  const std::vector<Vec3d> corners{
      {-size, -size, 0}, {size, -size, 0}, {size, size, 0.05}, {-size, size, 0}};
  SmallShape fan{corners, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};
  fan.vertices.push_back({0, 0, 0.1});
  return {{corners, {{0, 1, 2}, {0, 2, 3}}}, {corners, {{0, 1, 3}, {1, 2, 3}}}, fan};
}

RigidTransform rotated(const Vec3d& axis, double angle, const Vec3d& place) {
  const double s = std::sin(angle), c = std::cos(angle), d = 1 - c;
  const auto& [x, y, z] = axis;
  return {{c + x * x * d, x * y * d - z * s, x * z * d + y * s, y * x * d + z * s, c + y * y * d,
           y * z * d - x * s, z * x * d - y * s, z * y * d + x * s, c + z * z * d},
          {place.x, place.y, place.z}};
}

TriangleMesh toMesh(const SmallShape& shape) {
  TriangleMesh mesh;
  for (const Vec3d& v : shape.vertices) {
    for (const double x : {v.x, v.y, v.z}) mesh.vertices.push_back(static_cast<float>(x));
  }
  for (const auto& triangle : shape.triangles) {
    mesh.triangles.insert(mesh.triangles.end(), triangle.begin(), triangle.end());
  }
  return mesh;
}

geometry_msgs::TransformStamped toMessage(const std::string& parent, const std::string& child,
                                          const ros::Time& stamp, const Vec3d& place,
                                          const Vec3d& axis, double angle) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.header.stamp = stamp;
  message.child_frame_id = child;
  message.transform.translation.x = place.x;
  message.transform.translation.y = place.y;
  message.transform.translation.z = place.z;
  message.transform.rotation.x = axis.x * std::sin(angle / 2);
  message.transform.rotation.y = axis.y * std::sin(angle / 2);
  message.transform.rotation.z = axis.z * std::sin(angle / 2);
  message.transform.rotation.w = std::cos(angle / 2);
  return message;
}

}  // namespace

MonitorParameters randomParameters(Dice* dice) {
  MonitorParameters p;
  p.reference_frame = "base";
  p.motion = dice->chance(0.6) ? Motion::kSwept : Motion::kInstant;
  p.margin_m = dice->oneOf<float>({0, 0.02F, 0.1F});
  p.objects = {{"cloth", "", p.margin_m, true}, {"cable", "", p.margin_m, true}};
  for (ObjectParameters& object : p.objects) object.shares_margin = true;
  p.pair_classes = {dice->chance(0.8), dice->chance(0.6), false, dice->chance(0.6)};
  p.pair_classes.robot_self |= !p.pair_classes.robot_deformable;
  p.containment = dice->chance(0.4);
  p.detector.threads = 1;
  if (p.motion == Motion::kInstant && dice->chance(0.4)) p.detector.tolerance_m = 0.01F;
  p.budget_ms = dice->chance(0.2) ? 20 : 0;
  p.max_rate_hz = dice->oneOf<double>({0, 100, 20});
  p.robot_rate_hz = dice->oneOf<double>({10, 30, 100});
  p.tf_timeout_s = dice->oneOf<double>({0, 0.05});
  p.max_mesh_age_s = dice->oneOf<double>({0.3, 0.5});
  p.swept_tolerance_m = dice->oneOf<double>({1e-4, 1e-3});
  p.tolerated_rejects = dice->oneOf<double>({0, 0.6});
  p.since_survives_s = dice->oneOf<double>({0, 0.2});
  return p;
}

StateWorld::StateWorld(std::uint64_t seed, double trouble, const MonitorParameters& parameters)
    : dice_(seed),
      trouble_(trouble),
      start_(std::chrono::steady_clock::now() + std::chrono::hours(1000)) {
  const std::size_t link_count = 2 + dice_.below(2);
  const auto addFrame = [this](const std::string& name, const std::string& parent, double reach) {
    frames_.push_back({name, parent, randomMotion(reach), dice_.from(0.005, 0.03), 0, 0, {}});
  };
  auto robot = std::make_shared<RobotGeometry>(), other = std::make_shared<RobotGeometry>();
  for (std::size_t i = 0; i < link_count; ++i) {
    const std::string name = "link" + std::to_string(i);
    addFrame(name, i == 1 && dice_.chance(0.5) ? "link0" : "base", 0.35);
    links_[name] = tetrahedron(dice_.from(0.04, 0.15));
    robot->links.push_back({name, "test", toMesh(links_[name]), ""});
    if (i > 0) other->links.push_back(robot->links.back());
    robot->link_names.insert(name);
  }
  other->link_names = robot->link_names;
  robots_[0] = robot;
  robots_[1] = parameters.pair_classes.needRobot() ? other : robot;
  addFrame("camera", "base", 0.1);
  for (const bool is_sheet : {true, false}) {
    const double size = dice_.from(0.03, 0.3);
    objects_.push_back({randomMotion(0.35),
                        dice_.chance(0.6) ? "base" : "camera",
                        is_sheet ? sheets(size) : std::vector{octahedron(size), tetrahedron(size)},
                        dice_.from(0.015, 0.06),
                        0,
                        0,
                        0,
                        0,
                        0,
                        {},
                        {}});
    objects_.back().topology = topologies_++;
  }
}

StateWorld::Motion StateWorld::randomMotion(double reach) {
  Motion motion;
  const auto vector = [this](double most) {
    return Vec3d{dice_.from(-most, most), dice_.from(-most, most), dice_.from(-most, most)};
  };
  motion.middle = vector(0.1);
  motion.reach = vector(reach);
  for (double& speed : motion.speeds) speed = dice_.from(1, 8);
  for (double& phase : motion.phases) phase = dice_.from(0, 6);
  motion.axis = vector(1) + Vec3d{0, 0, 0.01};
  motion.axis = motion.axis * (1 / std::sqrt(dot(motion.axis, motion.axis)));
  motion.turn = dice_.chance(0.7) ? dice_.from(-1.5, 1.5) : 0;
  motion.turn_speed = dice_.from(0.5, 4);
  return motion;
}

Vec3d StateWorld::Motion::place(double time) const {
  return middle + Vec3d{reach.x * std::sin(speeds[0] * time + phases[0]),
                        reach.y * std::sin(speeds[1] * time + phases[1]),
                        reach.z * std::sin(speeds[2] * time + phases[2])};
}

ros::Time StateWorld::now() const { return ros::Time(std::max(1.0, clock_s_ + offset_s_)); }

void StateWorld::setRate(double rate) { rate_ = rate; }

void StateWorld::silence(std::size_t source, double seconds) {
  (source < 2 ? objects_[source].silent_until_s : frames_[source - 2].silent_until_s) =
      steady_s_ + seconds;
}

// Most messages take a moment, and some a long one.
double StateWorld::delay() {
  if (trouble_ == 0) return dice_.from(0, 0.004);
  return goesWrong(0.05) ? dice_.from(0, 0.3) : dice_.from(0, 0.02);
}

void StateWorld::advance(double seconds, bool holds_transforms, MeshInputs* meshes,
                         TransformBuffer* buffer) {
  steady_s_ += seconds;
  clock_s_ += seconds * rate_;
  for (Frame& frame : frames_) {
    if (steady_s_ < frame.due_s) continue;
    frame.due_s = steady_s_ + frame.period_s * dice_.from(0.9, 1.1);
    const bool is_lost = goesWrong(0.1);
    if (!is_lost && steady_s_ >= frame.silent_until_s) sendTransform(&frame, buffer);
  }
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (steady_s_ < objects_[i].due_s) continue;
    objects_[i].due_s = steady_s_ + objects_[i].period_s * dice_.from(0.9, 1.1);
    if (steady_s_ >= objects_[i].silent_until_s) sendMesh(i, meshes);
  }
  std::vector<Delivery> waiting, due;
  for (Delivery& delivery : underway_) {
    const bool waits = delivery.due_s > steady_s_ || (delivery.is_transform && holds_transforms);
    (waits ? waiting : due).push_back(std::move(delivery));
  }
  underway_ = std::move(waiting);
  if (!holds_transforms) noteClearedBuffer(buffer);
  for (const Delivery& delivery : due) delivery.deliver();
}

void StateWorld::sendTransform(Frame* frame, TransformBuffer* buffer) {
  const ros::Time stamp = now();
  const Sample sample{frame->motion.place(steady_s_), frame->motion.angle(steady_s_)};
  underway_.push_back(
      {steady_s_ + delay(), true, [=] { putTransform(frame, stamp, sample, buffer); }});
}

// Does what TransformInput does in the node. What is ahead of the clock was under way when the
// clock went back, and tells nothing of the time since.
void StateWorld::putTransform(Frame* frame, const ros::Time& stamp, const Sample& sample,
                              TransformBuffer* buffer) {
  buffer->lookAtClock(steady());
  noteClearedBuffer(buffer);
  if (!isUsableStamp(stamp, now()) || frame->samples.count(stamp) > 0) return;
  if (!buffer->add(toMessage(frame->parent, frame->name, stamp, sample.place, frame->motion.axis,
                             sample.angle),
                   "test", false, steady()) ||
      secondsBetween(stamp, now()) > kClockToleranceS) {
    return;
  }
  frame->samples[stamp] = sample;
  const ros::Time newest = frame->samples.rbegin()->first;
  while (secondsBetween(newest, frame->samples.begin()->first) > kKeptS) {
    frame->samples.erase(frame->samples.begin());
  }
}

void StateWorld::noteClearedBuffer(TransformBuffer* buffer) {
  if (buffer->canTransform("base", kSentinel, ros::Time(0))) return;
  for (Frame& frame : frames_) frame.samples.clear();
  buffer->setTransform(toMessage("base", kSentinel, ros::Time(1), {}, {0, 0, 1}, 0), "test");
}

void StateWorld::sendMesh(std::size_t index, MeshInputs* meshes) {
  Object& object = objects_[index];
  auto message = boost::make_shared<DeformableMesh>();
  SentMesh sent = newMesh(&object, message.get());
  std::string problem;
  if (goesWrong(0.04)) sent.is_good = !spoil(message.get(), &problem);
  const ros::Time stamp = message->header.stamp;
  if (!object.stamps.insert(stamp).second) return;  // the clock stands still
  underway_.push_back({steady_s_ + delay(), false, [=] {
                         objects_[index].sent[stamp] = sent;
                         IncomingMesh mesh{message, problem};
                         mesh.arrival = steady();
                         (*meshes)[index].store(std::move(mesh));
                       }});
}

// Makes a mesh, and a message of it. Triangles are sent now and then, and when they change.
SentMesh StateWorld::newMesh(Object* object, DeformableMesh* message) {
  if (goesWrong(0.02)) {
    object->shape = dice_.below(object->shapes.size());
    object->topology = topologies_++;
    object->since_keyframe = 0;
  }
  if (goesWrong(0.01)) object->frame = dice_.chance(0.5) ? "base" : "camera";
  SentMesh sent{object->frame, object->shapes[object->shape], object->topology};
  const RigidTransform pose = rotated(object->motion.axis, object->motion.angle(steady_s_),
                                      object->motion.place(steady_s_));
  for (Vec3d& v : sent.shape.vertices) v = toDouble(toFloat(transformed(pose, v)));
  if (goesWrong(0.03)) {
    sent.shape.vertices[dice_.below(4)].y = std::numeric_limits<double>::quiet_NaN();
  }
  const TriangleMesh mesh = toMesh(sent.shape);
  message->header.stamp = now();
  message->header.frame_id = object->frame;
  message->topology_id = object->topology;
  message->vertices = mesh.vertices;
  if (object->since_keyframe++ % 8 == 0) message->triangles = mesh.triangles;
  return sent;
}

// Makes a message invalid, and returns true; or leaves it as it is.
bool StateWorld::spoil(DeformableMesh* message, std::string* problem) {
  switch (dice_.below(7)) {
    case 0:
      message->vertices.pop_back();
      return true;
    case 1:
      message->topology_id = topologies_++;
      message->triangles = {0, 1, 99};
      return true;
    case 2:
      message->topology_id = topologies_++;
      message->triangles.clear();
      return true;
    case 3:
      message->header.frame_id.clear();
      return true;
    case 4:
      message->object = "another";
      return true;
    case 5:
      *problem = "its bytes are not a mesh";
      return true;
    default:  // valid as soon as the clock is there
      message->header.stamp += ros::Duration(dice_.from(1.1, 3));
      return false;
  }
}

std::optional<StateWorld::Sample> StateWorld::sampleAt(const Frame& frame,
                                                       const ros::Time& stamp) const {
  const auto after = frame.samples.lower_bound(stamp);
  if (after == frame.samples.end()) return std::nullopt;
  if (after->first == stamp) return after->second;
  if (after == frame.samples.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double part =
      secondsBetween(stamp, before->first) / secondsBetween(after->first, before->first);
  const Sample &a = before->second, &b = after->second;
  return Sample{a.place + (b.place - a.place) * part, a.angle + (b.angle - a.angle) * part};
}

std::optional<RigidTransform> StateWorld::edgeAt(const Frame& frame, const ros::Time& stamp) const {
  const std::optional<Sample> sample = sampleAt(frame, stamp);
  if (!sample) return std::nullopt;
  return rotated(frame.motion.axis, sample->angle, sample->place);
}

std::optional<RigidTransform> StateWorld::poseAt(const std::string& name,
                                                 const ros::Time& stamp) const {
  if (name == "base") return RigidTransform();
  const auto frame = std::find_if(frames_.begin(), frames_.end(),
                                  [&](const Frame& one) { return one.name == name; });
  if (frame == frames_.end()) return std::nullopt;
  const std::optional<RigidTransform> edge = edgeAt(*frame, stamp);
  const std::optional<RigidTransform> parent = poseAt(frame->parent, stamp);
  if (!edge || !parent) return std::nullopt;
  return composed(*parent, *edge);
}

SentMesh* StateWorld::mesh(std::size_t object, const ros::Time& stamp) {
  const auto found = objects_[object].sent.find(stamp);
  return found == objects_[object].sent.end() ? nullptr : &found->second;
}

void StateWorld::noteReset() {
  for (Object& object : objects_) {
    for (auto& [stamp, mesh] : object.sent) mesh.is_good = mesh.is_good && !mesh.was_used;
  }
}

const SmallShape* StateWorld::link(const std::string& name) const {
  const auto found = links_.find(name);
  return found == links_.end() ? nullptr : &found->second;
}

}  // namespace deformable_contact_monitor
