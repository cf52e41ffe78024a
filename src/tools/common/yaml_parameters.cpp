// Reads parameters from a yaml file, as rosparam would load it into a parameter server.
#include "tools/common/yaml_parameters.h"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {
namespace {

// Limits what a file may hold: the depth of lists and maps, the number of values (20 000 rules for
// allowed contacts need fewer), and the text in all of them. Otherwise a few lines with yaml's
// aliases could stand for billions of values.
constexpr int kDeepest = 32;
// Values are counted each time that an alias repeats them.
constexpr std::size_t kMostValues = 100000;
constexpr std::size_t kMostCharacters = std::size_t{16} << 20U;

// Converts a scalar as rosparam does: quoted values are texts, others may be numbers or booleans.
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

// Counts everything that was converted so far.
struct Size {
  std::size_t values = 0, characters = 0;
};

// Converts a node and everything below it, and adds to `size`. If a key of a map is there twice,
// the last value counts, as in rosparam.
void fill(const YAML::Node& node, int depth, Size* size, XmlRpc::XmlRpcValue* value) {
  if (depth > kDeepest) {
    throw YAML::ParserException(node.Mark(), "nested too deeply");
  }
  value->clear();
  ++size->values;
  if (node.IsScalar()) size->characters += node.Scalar().size();
  if (size->values > kMostValues || size->characters > kMostCharacters) {
    throw YAML::ParserException(node.Mark(), "too many values, or too much text");
  }
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      *value = fromScalar(node);
      break;
    case YAML::NodeType::Sequence:
      value->setSize(static_cast<int>(node.size()));
      for (int i = 0; i < value->size(); ++i) fill(node[i], depth + 1, size, &(*value)[i]);
      break;
    case YAML::NodeType::Map:
      for (const auto& entry : node) {
        if (!entry.first.IsScalar()) throw YAML::ParserException(node.Mark(), "a key is no text");
        // rosparam merges; yaml-cpp does not, and the values would be missing without a word.
        if (entry.first.Scalar() == "<<") {
          throw YAML::ParserException(node.Mark(),
                                      "merge keys (<<) are not supported here; "
                                      "write the values where they belong");
        }
        fill(entry.second, depth + 1, size, &(*value)[entry.first.Scalar()]);
      }
      break;
    default:
      *value = std::string();
  }
}

// Returns the line in which a second document begins; 0: there is one at most. A line that begins
// with "---" or "..." is such a mark wherever it stands (YAML 1.2, 9.1.2). yaml-cpp's LoadAll would
// tell it, too, but does not end on some malformed files.
int secondDocument(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  bool has_content = false, is_over = false;
  for (int number = 1; std::getline(file, line); ++number) {
    if (number == 1 && line.compare(0, 3, "\xEF\xBB\xBF") == 0)
      line.erase(0, 3);  // byte order mark
    const std::string mark = line.substr(0, 3);
    const bool is_mark = line.find_first_of(" \t\r", 3) == 3 || line.size() == 3;
    const bool begins = mark == "---" && is_mark;
    if (begins && (has_content || is_over)) return number;
    if (mark == "..." && is_mark) {
      is_over = has_content;
      continue;
    }
    const std::size_t at = line.find_first_not_of(" \t\r");
    const bool is_content =
        begins || (at != std::string::npos && line[at] != '#' && line[0] != '%');
    if (is_content && is_over) return number;
    has_content |= is_content;
  }
  return 0;
}

// Reads the file. Errors name it and the line.
YAML::Node load(const std::string& path) {
  try {
    const YAML::Node first = YAML::LoadFile(path);
    if (const int line = secondDocument(path)) {
      throw std::runtime_error(path + ": a second document begins in line " + std::to_string(line) +
                               "; put all into one");
    }
    return first;
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
    Size size;
    XmlRpc::XmlRpcValue parameters;
    fill(root, 0, &size, &parameters);
    return parameters;
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ": " + error.msg + ", line " +
                             std::to_string(error.mark.line + 1));
  }
}

// Decides by the first character what the file holds.
std::string readRobotDescription(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  // The byte order mark that some editors write is no part of the text.
  if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) text.erase(0, 3);
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (!file || start == std::string::npos) {
    throw std::runtime_error(path + ": cannot be read, or is empty");
  }
  // A URDF begins with an element or a declaration of XML; yaml never begins with <.
  if (text[start] == '<') return text;
  const YAML::Node root = load(path);
  if (root.IsScalar()) return root.Scalar();
  if (root.IsMap() && root["robot_description"] && root["robot_description"].IsScalar()) {
    return root["robot_description"].Scalar();
  }
  throw std::runtime_error(path + ": neither a URDF nor a rosparam dump of robot_description");
}

}  // namespace deformable_contact_monitor
