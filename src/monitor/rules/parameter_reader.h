// Reads a tree of ROS parameters, collecting every problem instead of stopping at the first.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// A value that is absent, of the wrong type or out of range reads as its fallback; the latter two
// are problems. Ranges are closed.
class ParameterReader {
 public:
  // `where` precedes names in messages: "~", "~objects[0]/". `problems` must outlive the reader.
  ParameterReader(const XmlRpc::XmlRpcValue& tree, std::string where,
                  std::vector<std::string>* problems);

  bool flag(const std::string& name, bool fallback);
  int integer(const std::string& name, int fallback, int low, int high);
  double number(const std::string& name, double fallback, double low, double high);
  // Not empty.
  std::string text(const std::string& name, const std::string& fallback);
  // The index of the value among `choices`.
  std::size_t choice(const std::string& name, const std::vector<std::string>& choices,
                     std::size_t fallback);
  std::vector<std::string> texts(const std::string& name);
  std::vector<int> integers(const std::string& name, int low, int high);
  std::map<std::string, double> numbers(const std::string& name, double low, double high);
  // One reader for each struct of a list.
  std::vector<ParameterReader> structs(const std::string& name);

  // Whether it is there.
  bool has(const std::string& name) { return find(name) != nullptr; }

  void addProblem(const std::string& name, const std::string& what);

  // Names that are there but were never asked for, each with the nearest that was.
  std::vector<std::string> unknown() const;

 private:
  // The value if it is there; notes that the name is known.
  const XmlRpc::XmlRpcValue* find(const std::string& name);
  bool toInteger(const std::string& name, const XmlRpc::XmlRpcValue& value, int low, int high,
                 int* integer);
  bool toNumber(const std::string& name, const XmlRpc::XmlRpcValue& value, double low, double high,
                double* number);

  XmlRpc::XmlRpcValue tree_;
  std::string where_;
  std::vector<std::string>* problems_;
  std::set<std::string> known_;
};

}  // namespace deformable_contact_monitor
