// Nodes and skins of a COLLADA file that refer to others.
#include "robot/read_link_mesh/collada_references.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "robot/read_link_mesh/index_text.h"

namespace deformable_contact_monitor {
namespace {

using tinyxml2::XMLElement;

// A robot link has some; Assimp takes 2 KiB for each.
constexpr std::uint64_t kMaxNodes = 100'000;

// Assimp's stack grows with it.
constexpr std::size_t kMaxDepth = 200;

[[noreturn]] void fail(const XMLElement& at, const std::string& what) {
  throw std::runtime_error("line " + std::to_string(at.GetLineNum()) + ": " + what);
}

[[noreturn]] void failForDepth(const XMLElement& at) {
  fail(at, "nodes are more than " + std::to_string(kMaxDepth) + " deep");
}

bool is(const XMLElement& element, const char* name) {
  return std::strcmp(element.Name(), name) == 0;
}

// Without the '#' of a reference within the file.
std::string text(const XMLElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  return value == nullptr ? "" : value + (*value == '#' ? 1 : 0);
}

class Collector : public tinyxml2::XMLVisitor {
 public:
  bool VisitEnter(const XMLElement& element, const tinyxml2::XMLAttribute*) override {
    if (is(element, "node")) {
      nodes.push_back(&element);
      const XMLElement* parent = element.Parent()->ToElement();
      if (parent != nullptr && is(*parent, "library_nodes")) {
        in_library[text(element, "id")].push_back(&element);
      }
      by_id[text(element, "id")].push_back(&element);
      by_name[text(element, "name")].push_back(&element);
    } else if (is(element, "skin") || is(element, "morph")) {
      const XMLElement* controller = element.Parent()->ToElement();
      if (controller != nullptr) deformed_by[text(*controller, "id")] = &element;
    }
    return true;
  }

  // Whom an <instance_node> may mean to Assimp, which looks in the library first.
  std::vector<const XMLElement*> named(const std::string& url) const {
    for (const auto* names : {&in_library, &by_id, &by_name}) {
      const auto found = names->find(url);
      if (found != names->end()) return found->second;
    }
    return {};
  }

  std::vector<const XMLElement*> nodes;
  std::map<std::string, std::vector<const XMLElement*>> in_library, by_id, by_name;
  std::map<std::string, const XMLElement*> deformed_by;  // <skin> or <morph>, by their controller
};

// How many nodes each node comes to, and how deep, with all that it instances.
class NodeTree {
 public:
  explicit NodeTree(const Collector& collected) : collected_(collected) {}

  void check(const XMLElement& node) {
    if (extent_.count(&node) == 0) measure(node, 0);
  }

 private:
  struct Extent {
    std::uint64_t nodes = 1;
    std::size_t depth = 1;
  };

  Extent measure(const XMLElement& node, std::size_t above) {
    const auto known = extent_.find(&node);
    if (known != extent_.end()) return known->second;
    if (!open_.insert(&node).second) {
      fail(node, "node '" + shortened(text(node, "id")) + "' instances itself");
    }
    Extent extent;
    const auto add = [&](const XMLElement& child) {
      if (above >= kMaxDepth) failForDepth(child);
      const Extent its = measure(child, above + 1);
      extent.nodes += its.nodes;
      extent.depth = std::max(extent.depth, its.depth + 1);
      if (extent.nodes > kMaxNodes) {
        fail(node, "instances come to more than " + std::to_string(kMaxNodes) + " nodes");
      }
      if (extent.depth > kMaxDepth) failForDepth(node);
    };
    for (const XMLElement* e = node.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement()) {
      if (is(*e, "node")) add(*e);
      if (!is(*e, "instance_node")) continue;
      for (const XMLElement* target : collected_.named(text(*e, "url"))) add(*target);
    }
    open_.erase(&node);
    return extent_[&node] = extent;
  }

  const Collector& collected_;
  std::map<const XMLElement*, Extent> extent_;
  std::set<const XMLElement*> open_;
};

void checkSkins(const Collector& collected) {
  std::set<const XMLElement*> done;
  for (const auto& [controller, first] : collected.deformed_by) {
    std::set<const XMLElement*> open;
    for (const XMLElement* at = first; done.count(at) == 0;) {
      if (!open.insert(at).second) {
        fail(*first, "controller '" + shortened(controller) + "' deforms itself");
      }
      const auto next = collected.deformed_by.find(text(*at, "source"));
      if (next == collected.deformed_by.end()) break;
      at = next->second;
    }
    done.insert(open.begin(), open.end());
  }
}

}  // namespace

void checkColladaReferences(const tinyxml2::XMLDocument& document) {
  Collector collected;
  document.Accept(&collected);
  NodeTree tree(collected);
  for (const XMLElement* node : collected.nodes) tree.check(*node);
  checkSkins(collected);
}

}  // namespace deformable_contact_monitor
