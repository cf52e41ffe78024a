// Reads the index of a bag, which has the time and the place of each message.
#include "tools/bags/recorded_order.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "monitor/input/transform_lookup.h"
#include "tools/bags/bag_messages.h"
#include "tools/bags/bag_records.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::int64_t kOrderNs = 200000000;  // times may be out of order by this
// Where time falls after fewer messages, no clock went back: the file is in no order.
constexpr std::size_t kFewestPerFall = 3;

struct IndexedMessage {
  std::int64_t received_ns = 0;
  std::uint64_t place = 0;  // in the file
  std::uint32_t connection = 0;
  std::size_t rank = 0;
  std::size_t part = 0;  // how often the clock had gone back
};

// Ranks are those of rosbag's view, which keeps the index's order where times are equal.
void setRanks(std::vector<IndexedMessage>* messages) {
  std::map<std::uint32_t, std::vector<IndexedMessage*>> connections;
  for (IndexedMessage& message : *messages) connections[message.connection].push_back(&message);
  for (auto& [number, of] : connections) {
    std::stable_sort(of.begin(), of.end(), [](const IndexedMessage* a, const IndexedMessage* b) {
      return a->received_ns < b->received_ns;
    });
    for (std::size_t i = 0; i < of.size(); ++i) of[i]->rank = i;
  }
}

// Returns the messages in the order of the file.
std::vector<IndexedMessage> readIndex(const std::string& path,
                                      const std::set<std::uint32_t>& connections) {
  RecordFile file(path);
  std::vector<IndexedMessage> messages;
  std::uint64_t chunk = 0;
  RecordFields fields;
  std::uint32_t size = 0;
  while (file.next(&fields, &size)) {
    const std::string& op = fields["op"];
    chunk += op == std::string(1, RecordFile::kChunk);
    if (op != std::string(1, RecordFile::kIndexData) ||
        connections.count(RecordFile::numberAt(fields["conn"], 0)) == 0) {
      file.skip(size);
      continue;
    }
    const std::string data = file.bytes(size);
    for (std::size_t at = 0; at < data.size(); at += RecordFile::kIndexEntry) {
      IndexedMessage& message = messages.emplace_back();
      message.received_ns = std::int64_t{1000000000} * RecordFile::numberAt(data, at) +
                            RecordFile::numberAt(data, at + 4);
      message.place = (chunk << 32U) + RecordFile::numberAt(data, at + 8);
      message.connection = RecordFile::numberAt(fields["conn"], 0);
    }
  }
  setRanks(&messages);
  std::sort(messages.begin(), messages.end(),
            [](const IndexedMessage& a, const IndexedMessage& b) { return a.place < b.place; });
  return messages;
}

// Follows the times of one connection.
class Restarts {
 public:
  void look(std::int64_t time_ns) {
    ++count_;
    if (time_ns < newest_ns_ - kOrderNs) {
      ++falls_;
      earlier_ = {std::min(earlier_.first, first_ns_), std::max(earlier_.second, newest_ns_)};
      first_ns_ = newest_ns_ = time_ns;
    }
    first_ns_ = std::min(first_ns_, time_ns);
    newest_ns_ = std::max(newest_ns_, time_ns);
    repeats_ |= first_ns_ < earlier_.second && newest_ns_ > earlier_.first;
  }
  std::size_t falls() const { return falls_; }
  bool found() const { return repeats_ && kFewestPerFall * falls_ <= count_; }

 private:
  static constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() / 2;

  std::size_t count_ = 0, falls_ = 0;
  std::int64_t first_ns_ = kMost, newest_ns_ = kLeast;
  std::pair<std::int64_t, std::int64_t> earlier_{kMost, kLeast};  // before the time fell
  bool repeats_ = false;
};

bool hasRestarts(const std::vector<IndexedMessage>& messages,
                 const std::set<std::uint32_t>& decisive, const Contradicts& contradicts) {
  struct Connection {
    Restarts restarts;
    std::vector<std::size_t> parts;  // by rank
  };
  std::map<std::uint32_t, Connection> connections;
  for (const IndexedMessage& message : messages) {
    Connection& of = connections[message.connection];
    of.restarts.look(message.received_ns);
    if (of.parts.size() <= message.rank) of.parts.resize(message.rank + 1);
    of.parts[message.rank] = of.restarts.falls();
  }
  return std::any_of(connections.begin(), connections.end(), [&](const auto& named) {
    const auto& [number, of] = named;
    return of.restarts.found() && (decisive.count(number) > 0 || contradicts(number, of.parts));
  });
}

// Sorts the messages by their times between two falls of the clock.
void sortParts(std::vector<IndexedMessage>* messages) {
  std::int64_t newest_ns = messages->front().received_ns;
  std::size_t part = 0;
  for (IndexedMessage& message : *messages) {
    const bool falls = message.received_ns < newest_ns - kOrderNs;
    part += falls;
    newest_ns = falls ? message.received_ns : std::max(newest_ns, message.received_ns);
    message.part = part;
  }
  std::sort(
      messages->begin(), messages->end(), [](const IndexedMessage& a, const IndexedMessage& b) {
        return std::tie(a.part, a.received_ns, a.place) < std::tie(b.part, b.received_ns, b.place);
      });
}

}  // namespace

std::vector<OrderedMessage> recordedOrder(const std::string& path,
                                          const std::set<std::uint32_t>& connections,
                                          const std::set<std::uint32_t>& decisive,
                                          const Contradicts& contradicts) {
  std::vector<IndexedMessage> messages = readIndex(path, connections);
  if (!hasRestarts(messages, decisive, contradicts)) return {};
  sortParts(&messages);
  std::vector<OrderedMessage> order;
  std::int64_t shift_ns = 0, newest_ns = messages.front().received_ns - 1;
  std::size_t part = 0;
  for (const IndexedMessage& message : messages) {
    if (message.part > part) shift_ns = newest_ns - message.received_ns;
    part = message.part;
    // No two are equal, so that those before the clock went back can be told from those after it.
    newest_ns = std::max(newest_ns + 1, message.received_ns + shift_ns);
    ros::Time received;
    received.fromNSec(static_cast<std::uint64_t>(newest_ns));
    order.push_back({message.connection, message.rank, received});
  }
  return order;
}

void EpisodesOfTransforms::beginPart() {
  for (auto& [frame, track] : current_) earlier_[frame].merge(track);
  current_.clear();
}

void EpisodesOfTransforms::add(const geometry_msgs::TransformStamped& transform) {
  if (!isValid(transform)) return;
  const std::string frame = plainFrame(transform.child_frame_id);
  const ros::Time& stamp = transform.header.stamp;
  const PoseInParent place = placeOf(transform);
  const auto earlier = earlier_.find(frame);
  if (earlier != earlier_.end()) {
    differences_ += contradicts(earlier->second, stamp, place, kLongestStepS);
  }
  if (stored_ == kMost) return;
  ++stored_;
  current_[frame][stamp] = place;
}

}  // namespace deformable_contact_monitor
