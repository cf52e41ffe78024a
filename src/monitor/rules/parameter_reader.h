// Reads a tree of ROS parameters and collects every problem, so that a user sees all at once.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

// Each function returns the named value, or the fallback (an empty container where there is none)
// if the value is absent, of the wrong type or out of range. The latter two add a line to the
// problems. Ranges include their ends. Not safe for use by several threads.
class ParameterReader {
 public:
  // `where` precedes names in messages, such as "~" or "~objects[0]/". `problems` must outlive the
  // reader. A `tree` that is neither invalid (nothing is set) nor a map is a problem.
  ParameterReader(const XmlRpc::XmlRpcValue& tree, std::string where,
                  std::vector<std::string>* problems);

  bool flag(const std::string& name, bool fallback);
  int integer(const std::string& name, int fallback, int low, int high);
  // A text such as 1e-3 is a number: YAML 1.1, which rosparam and roslaunch read, takes a number
  // with an exponent for a text unless it has a decimal point and the exponent has a sign.
  double number(const std::string& name, double fallback, double low, double high);
  // An empty text is a problem for the first, and a value for the second.
  std::string text(const std::string& name, const std::string& fallback);
  std::string optionalText(const std::string& name, const std::string& fallback);
  // Returns the index of the value among `choices`; `fallback` is an index, too.
  std::size_t choice(const std::string& name, const std::vector<std::string>& choices,
                     std::size_t fallback);
  std::vector<std::string> texts(const std::string& name,
                                 const std::vector<std::string>& fallback = {});
  std::vector<int> integers(const std::string& name, int low, int high);
  // A name with slashes may be a map within the map: the parameter server makes {left: {hand: 1}}
  // of {left/hand: 1}.
  std::map<std::string, double> numbers(const std::string& name, double low, double high);
  // Returns the pairs of whole numbers of a list of lists, each ascending: [[0, 99], [200, 250]].
  std::vector<std::pair<int, int>> ranges(const std::string& name, int low, int high);
  // Returns the three numbers of a list: [0.1, 0, 0]; nothing unless there are three.
  std::optional<std::array<double, 3>> point(const std::string& name);
  // Returns a reader for a map; nothing if the value is absent. It adds to the same problems.
  std::optional<ParameterReader> section(const std::string& name);
  // Returns one reader for each map of a list. They add to the same problems.
  std::vector<ParameterReader> structs(const std::string& name);

  // Returns whether the value is set, and counts as asking for it.
  bool has(const std::string& name) { return find(name) != nullptr; }

  // Adds "<where><name> <what>" to the problems.
  void addProblem(const std::string& name, const std::string& what);

  // Returns the names that are set but were never asked for, each with the nearest known name.
  std::vector<std::string> unknown() const;
  // Adds a warning for each of them, mostly a typing error.
  void warnOfUnknown(std::vector<std::string>* warnings) const;

  // Adds a problem if the TF frame, or the beginning of one, begins with '/'.
  void refuseSlash(const std::string& name, const std::string& frame);

  // Returns what is set to another value than its fallback, as "<name>: <value>", in the order in
  // which it was asked for. Long values are cut.
  const std::vector<std::string>& changed() const { return changed_; }

 private:
  // Adds the numbers of a map within `name`, whose keys are preceded by `prefix`.
  void addNumbers(const std::string& name, const std::string& prefix,
                  const XmlRpc::XmlRpcValue& map, double low, double high,
                  std::map<std::string, double>* numbers);
  void addChanged(const std::string& name, const XmlRpc::XmlRpcValue& value);
  // Returns the value or null, and notes that the name is known.
  const XmlRpc::XmlRpcValue* find(const std::string& name);
  // Does the same, and adds the problem "must be `wanted`" if the value has another type.
  const XmlRpc::XmlRpcValue* find(const std::string& name, XmlRpc::XmlRpcValue::Type type,
                                  const std::string& wanted);
  bool toInteger(const std::string& name, const XmlRpc::XmlRpcValue& value, int low, int high,
                 int* integer);
  bool toNumber(const std::string& name, const XmlRpc::XmlRpcValue& value, double low, double high,
                double* number);

  XmlRpc::XmlRpcValue tree_;
  std::string where_;
  std::vector<std::string>* problems_;
  std::set<std::string> known_;
  std::vector<std::string> changed_;
};

// Replaces a text such as 1e-3 by the number. Returns whether `value` was such a text.
bool replaceTextByNumber(XmlRpc::XmlRpcValue* value);

// Does the same with all values of a map and of the maps within it.
bool replaceTextsByNumbers(XmlRpc::XmlRpcValue* map);

}  // namespace deformable_contact_monitor
