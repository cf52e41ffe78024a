// Writes bags of a small scene and evaluates them. The scene is a finger, a box of 0.1 m around the
// origin, and one triangle through it that a camera sees.
#pragma once

#include <deformable_contact_monitor/ContactEvent.h>
#include <ros/time.h>
#include <rosbag/bag.h>
#include <visualization_msgs/Marker.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "tools/bags/bag_setup.h"

namespace deformable_contact_monitor {

constexpr double kPeriod = 0.125;   // [s] of the meshes
constexpr double kDelay = 0.03125;  // [s] from a mesh's stamp to its recording

// Returns the time `s` after the beginning of the recording [s].
ros::Time at(double s);

// A bag that exists as long as this.
class WrittenBag {
 public:
  WrittenBag();
  WrittenBag(const WrittenBag&) = delete;
  WrittenBag& operator=(const WrittenBag&) = delete;
  ~WrittenBag();

  template <typename M>
  void add(const std::string& topic, const ros::Time& received, const M& message) {
    bag_.write(topic, received, message);
  }
  // Adds a transform that moves by z [m]. Of a static one the stamp has no meaning.
  void transform(const std::string& topic, const ros::Time& received, const ros::Time& stamp,
                 const std::string& frame, double z, const std::string& publisher = "");
  void camera(double s, double z, const std::string& publisher = "") {
    transform("/tf_static", at(s), at(s), "camera", z, publisher);
  }
  // The finger at the origin.
  void finger(double s) { transform("/tf", at(s), at(s), "finger", 0); }
  void mesh(const ros::Time& received, const ros::Time& stamp, const std::string& object);
  // Adds a marker of the same triangle, or the message that deletes it.
  void marker(double s, std::int32_t action) { add("/cloth", at(s + kDelay), markerOf(s, action)); }
  // The same as the marker ''/2 of an array, with a marker ''/1 that is deleted in the same array.
  void markerArray(double s, std::int32_t action);
  // Adds meshes with the finger's transforms at `count` stamps, from `first` times the period on.
  void meshes(int first, int count);
  // Adds link meshes: the finger as one triangle at height z [m], and other links beside it.
  void links(double s, double z, const std::string& more = "");
  void text(double s, const std::string& topic, const std::string& data);

  std::string finish();

 private:
  static visualization_msgs::Marker markerOf(double s, std::int32_t action);

  char path_[32] = "/tmp/recorded_time_XXXXXX.bag";
  rosbag::Bag bag_;
};

// Returns a robot whose finger is a box of 0.1 m, and slides along z or stands at `z` [m].
std::string urdf(const std::string& joint_type, double size, double z = 0);

// The states of the finger and an object stand in the order of the object's cycles: "C" is CONTACT,
// "-" NONE, "?" UNKNOWN.
struct Found {
  std::map<std::string, std::string> states;  // by object
  std::vector<ros::Time> stamps;              // of all cycles
  std::vector<ContactEvent> events;
  std::vector<std::string> warnings;
  std::uint64_t late_cycles = 0, bad_transforms = 0;  // as BagCycles counts them
};

Found evaluate(const BagFiles& files, const MonitorParameters& configured = MonitorParameters());

// Evaluates a bag with a URDF that is given beside it, or with what is in the bag.
Found evaluate(WrittenBag* bag, const std::string& urdf_xml = "",
               const MonitorParameters& parameters = MonitorParameters());

// Returns the cloth's states.
std::string statesOf(WrittenBag* bag, const std::string& urdf_xml = "");

std::string times(int count, char state);

}  // namespace deformable_contact_monitor
