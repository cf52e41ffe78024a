// Reads a bag's records once, to compare its index with what is there.
#include "tools/bags/bag_records.h"

namespace deformable_contact_monitor {
namespace {

// The size of an entry in a chunk's list of connections [bytes].
constexpr std::uint32_t kChunkInfoEntry = 8;

using Counts = std::map<std::uint32_t, std::uint64_t>;  // messages of each connection

}  // namespace

// Counts the messages of each connection twice: in the indices behind the chunks, and in the list
// of chunks at the end of the bag. Both, and the numbers in the bag's header, must agree.
void checkBagIndex(const std::string& path) {
  RecordFile file(path);
  std::map<char, std::uint64_t> records;  // by op
  std::uint64_t chunks = 0, connections = 0;
  Counts in_indices, in_chunk_list;
  RecordFields fields;
  std::uint32_t size = 0;
  while (file.next(&fields, &size)) {
    const std::string op = fields["op"];
    if (op.size() != 1) RecordFile::fail();
    ++records[op[0]];
    const std::string data = op[0] == RecordFile::kChunkInfo ? file.bytes(size) : "";
    if (op[0] != RecordFile::kChunkInfo) file.skip(size);
    if (op[0] == RecordFile::kBagHeader) {
      chunks = RecordFile::numberAt(fields["chunk_count"], 0);
      connections = RecordFile::numberAt(fields["conn_count"], 0);
    } else if (op[0] == RecordFile::kIndexData) {
      const std::uint64_t count = RecordFile::numberAt(fields["count"], 0);
      if (size != count * RecordFile::kIndexEntry) RecordFile::fail();
      in_indices[RecordFile::numberAt(fields["conn"], 0)] += count;
    } else if (op[0] == RecordFile::kChunkInfo) {
      const std::uint64_t count = RecordFile::numberAt(fields["count"], 0);
      if (size != count * kChunkInfoEntry) RecordFile::fail();
      for (std::size_t at = 0; at < data.size(); at += kChunkInfoEntry) {
        in_chunk_list[RecordFile::numberAt(data, at)] += RecordFile::numberAt(data, at + 4);
      }
    }
  }
  // A message that only one of the lists has would be lost silently.
  if (in_indices != in_chunk_list || records[RecordFile::kChunk] != chunks ||
      records[RecordFile::kChunkInfo] != chunks ||
      records[RecordFile::kConnection] != connections) {
    throw std::runtime_error("what it says about itself does not agree");
  }
}

}  // namespace deformable_contact_monitor
