// Notices when several nodes publish different meshes of one object, in turn.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "core/steady_time.h"
#include "monitor/input/incoming_mesh.h"

namespace deformable_contact_monitor {

// Two publishers are rivals if a mesh of one comes between two meshes of the other and equals
// neither. So a node that takes the place of another one is no rival, and neither are nodes that
// send the same. Any thread may call any function.
class RivalPublishers {
 public:
  // Takes each mesh in the order of arrival.
  void look(const IncomingMesh& mesh);

  // Takes a mesh whose publisher changed the triangles and kept their topology_id. It is described
  // like rivals.
  void noteReusedId(const IncomingMesh& mesh);

  // Returns which two nodes were rivals last, or which one changed triangles under their id,
  // whatever came later; empty: neither happened in the last 5 s before `now`.
  std::string describe(SteadyTime now) const;

 private:
  mutable std::mutex mutex_;                  // guards what follows
  std::map<std::string, IncomingMesh> last_;  // by publisher
  std::string rivals_;
  SteadyTime when_;
};

}  // namespace deformable_contact_monitor
