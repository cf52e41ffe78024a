// Parameters from a yaml file, as rosparam would load it into a parameter server.
#include "tools/common/yaml_parameters.h"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

constexpr int kDeepest = 32;  // lists of lists of lists: nobody's parameters

XmlRpc::XmlRpcValue fromScalar(const YAML::Node& node) {
  const bool quoted = node.Tag() == "!";
  int integer = 0;
  double number = 0;
  bool flag = false;
  if (!quoted && YAML::convert<int>::decode(node, integer)) return integer;
  if (!quoted && YAML::convert<double>::decode(node, number)) return number;
  if (!quoted && YAML::convert<bool>::decode(node, flag)) return flag;
  return node.Scalar();
}

XmlRpc::XmlRpcValue fromNode(const YAML::Node& node, int depth) {
  if (depth > kDeepest) {
    throw YAML::ParserException(node.Mark(), "nested too deeply");
  }
  XmlRpc::XmlRpcValue value;
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      return fromScalar(node);
    case YAML::NodeType::Sequence:
      value.setSize(static_cast<int>(node.size()));
      for (std::size_t i = 0; i < node.size(); ++i) {
        value[static_cast<int>(i)] = fromNode(node[i], depth + 1);
      }
      return value;
    case YAML::NodeType::Map:
      for (const auto& entry : node) {
        if (!entry.first.IsScalar()) throw YAML::ParserException(node.Mark(), "a key is no text");
        value[entry.first.Scalar()] = fromNode(entry.second, depth + 1);
      }
      return value;
    default:
      return std::string();
  }
}

YAML::Node load(const std::string& path) {
  try {
    return YAML::LoadFile(path);
  } catch (const YAML::BadFile&) {
    throw std::runtime_error(path + ": cannot be read");
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ": " + error.msg + ", line " +
                             std::to_string(error.mark.line + 1));
  }
}

}  // namespace

XmlRpc::XmlRpcValue readYamlParameters(const std::string& path) {
  const YAML::Node root = load(path);
  if (!root.IsDefined() || root.IsNull()) return XmlRpc::XmlRpcValue();
  try {
    return fromNode(root, 0);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ": " + error.msg + ", line " +
                             std::to_string(error.mark.line + 1));
  }
}

std::string readRobotDescription(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file || text.empty()) throw std::runtime_error(path + ": cannot be read, or is empty");
  if (text[text.find_first_not_of(" \t\r\n")] == '<') return text;
  const YAML::Node root = load(path);
  if (root.IsScalar()) return root.Scalar();
  if (root.IsMap() && root["robot_description"] && root["robot_description"].IsScalar()) {
    return root["robot_description"].Scalar();
  }
  throw std::runtime_error(path + ": neither a URDF nor a rosparam dump of robot_description");
}

}  // namespace deformable_contact_monitor
