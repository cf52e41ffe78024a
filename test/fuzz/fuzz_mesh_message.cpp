// Messages of a mesh, of any type that an object may have, from their bytes on the wire to the
// states of bodies: roscpp's reading behind our check, the adapters, the rules of acceptance, the
// scene, the CPU backend.
#include <geometry_msgs/TransformStamped.h>
#include <ros/message_event.h>
#include <ros/subscription_callback_helper.h>
#include <tf2/buffer_core.h>

#include <boost/make_shared.hpp>
#include <memory>
#include <vector>

#include "byte_source.h"
#include "core/cpu_detector.h"
#include "detector_check.h"
#include "fuzz_target.h"
#include "message_writer.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/input/mesh_subscription.h"
#include "monitor/messages/contact_messages.h"
#include "monitor/state/contact_state_tracker.h"

namespace deformable_contact_monitor {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMostMessages = 8;
constexpr std::size_t kMaxBytes = 1 << 16;

MonitorParameters makeParameters(MeshType type, bool has_faces) {
  MonitorParameters parameters;
  ObjectParameters object;
  object.name = "cloth";
  object.margin_m = 0.1F;
  object.type = type;
  object.frame_id = "camera";
  object.depth.max_depth_jump = 1;
  object.stamp_offset_s = -0.005;
  if (type >= MeshType::kPoints) object.radius_m = 0.0625F;
  if (has_faces) object.faces = std::make_shared<const PointTriangles>(fuzzedFaces());
  parameters.objects = {object};
  parameters.pair_classes.deformable_self = true;
  parameters.max_mesh_bytes = kMaxBytes;
  parameters.detector.threads = 1;
  return parameters;
}

RobotGeometry makeRobot() {
  const TriangleMesh tetrahedron{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
                                 {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}};
  RobotGeometry robot;
  robot.links = {{"base_link", "", tetrahedron, ""}, {"hand", "", tetrahedron, ""}};
  return robot;
}

void addStaticTransform(const std::string& frame, double x, tf2::BufferCore* buffer) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "base_link";
  transform.child_frame_id = frame;
  transform.transform.translation.x = x;
  transform.transform.rotation.w = 1;
  buffer->setTransform(transform, "fuzz", true);
}

// Does in one thread what the node does with the messages of one object.
class Monitor {
 public:
  Monitor(MeshType type, bool has_faces)
      : parameters_(makeParameters(type, has_faces)),
        scene_(parameters_),
        inputs_(makeMeshInputs(parameters_)),
        lookup_(buffer_, parameters_.reference_frame),
        subscription_(meshSubscription("/cloth", parameters_.objects[0], kMaxBytes,
                                       [this](const IncomingMesh& mesh) {
                                         has_mesh_ = true;
                                         was_mesh_ = mesh.problem.empty();
                                         inputs_[0].store(mesh);
                                       })),
        detector_(makeCpuDetector()),
        tracker_(StateRules()) {
    scene_.setRobot(makeRobot());
    addStaticTransform("camera", 0.25, &buffer_);
    addStaticTransform("hand", 0.5, &buffer_);
  }

  // Returns whether the bytes were a mesh. Some calls leave the mesh waiting, as a busy node does.
  bool arrive(Bytes bytes, const ros::Time& now, bool is_busy) {
    ros::SubscriptionCallbackHelperDeserializeParams wire;
    wire.buffer = bytes.data();
    wire.length = static_cast<std::uint32_t>(bytes.size());
    ros::SubscriptionCallbackHelperCallParams call;
    call.event =
        ros::MessageEvent<void const>(subscription_.helper->deserialize(wire), connection_, now,
                                      false, ros::MessageEvent<void const>::CreateFunction());
    has_mesh_ = was_mesh_ = false;
    subscription_.helper->call(call);
    if (was_mesh_) {
      const MeshType type = parameters_.objects[0].type;
      requireThat(bytesOf(type, call.event.getMessage()) == bytes,
                  "a message is not what was sent");
    }
    if (has_mesh_ && !is_busy) runCycle(now);
    return was_mesh_;
  }

 private:
  void runCycle(const ros::Time& now) {
    IncomingMesh mesh;
    if (inputs_[0].deletedAt()) inputs_[0].endGrace();
    const Acceptance answer = inputs_[0].take(now, &mesh);
    requireThat(answer != Acceptance::kNothing, "a message did not arrive");
    requireThat((answer == Acceptance::kRejected) == !inputs_[0].counters().problem.empty() ||
                    answer == Acceptance::kDropped,
                "a mesh was rejected without a reason");
    CycleTrigger trigger;
    trigger.objects = {0};
    const ros::Time& stamp = mesh.is_deletion ? now : mesh.stamp();
    scene_.prepare(stamp, trigger, inputs_, lookup_);
    CycleReport report = scene_.makeReport(stamp, ++cycle_);
    report.scene = &scene_.scene();
    report.now = now;
    report.options = parameters_.detector;
    if (!scene_.scene().enabledPairs().empty()) {
      requireThat(answer != Acceptance::kRejected, "a rejected mesh was looked at");
      report.result = std::make_shared<const DetectionResult>(
          detectChecked(detector_.get(), scene_.scene(), parameters_.detector));
      noteRejected(&report);
    }
    tracker_.update(report);
    check(tracker_.states(stamp, now), *report.scene);
    toContactArray(report, 0);
  }

  // Nothing is claimed of a body with a triangle that took no part.
  static void check(const ContactStates& states, const Scene& scene) {
    for (const ContactState& state : states.states) {
      requireThat(state.state != ContactState::UNKNOWN || !state.reason.empty(),
                  "UNKNOWN without a reason");
      const bool is_free = state.state == ContactState::NONE || state.state == ContactState::NEAR;
      const std::vector<float>& cloth = scene.bodies().back().mesh.vertices;
      requireThat(!is_free || !cloth.empty(), "no contact is claimed of no mesh");
    }
  }

  const MonitorParameters parameters_;
  MonitorScene scene_;
  MeshInputs inputs_;
  TransformBuffer buffer_;
  const TransformLookup lookup_;
  const ros::SubscribeOptions subscription_;
  const boost::shared_ptr<ros::M_string> connection_ = boost::make_shared<ros::M_string>();
  const std::unique_ptr<Detector> detector_;
  ContactStateTracker tracker_;
  bool has_mesh_ = false, was_mesh_ = false;  // the last message handed a mesh over, a valid one
  std::uint64_t cycle_ = 0;
};

// Returns the type of all messages of an input, from bits of its first byte: a MeshType, or
// kMeshTypes for images of a depth camera. An empty input has the type kDeformableMesh.
std::size_t typeOf(const std::uint8_t* data, std::size_t size) {
  constexpr int kShift = 4;
  return size == 0 ? 0 : (*data >> kShift) % (kMeshTypes + 1);
}

// Past the first check: some bytes were a mesh.
bool tryMeshMessage(const std::uint8_t* data, std::size_t size) {
  ByteSource source(data, size);
  const std::size_t number = typeOf(data, size);
  const bool is_image = number == kMeshTypes;
  const MeshType type = is_image ? MeshType::kPointCloud : static_cast<MeshType>(number);
  Monitor monitor(type, !is_image);
  bool any = false;
  ros::Time now(100, 0);
  for (std::size_t i = 0; i < kMostMessages && source.left() > 0; ++i) {
    constexpr int kRaw = 1, kBusy = 2, kBack = 4, kLeap = 8;
    const std::uint8_t how = source.byte();
    const ros::Duration step((how & kLeap) != 0 ? 3 : 0.01);
    now = (how & kBack) != 0 && now.sec > 50 ? now - step : now + step;
    const Bytes bytes = (how & kRaw) != 0 ? source.bytes(source.number<std::uint16_t>())
                                          : messageBytes(type, &source, now);
    any = monitor.arrive(bytes, now, (how & kBusy) != 0) || any;
  }
  return any;
}

const FuzzTargetEntry entry("mesh_message", tryMeshMessage);

}  // namespace
}  // namespace deformable_contact_monitor
