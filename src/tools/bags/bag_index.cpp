// What rosbag does not ask about a bag's index. Records are as http://wiki.ros.org/Bags/Format/2.0
// has them: a header of named fields, and data.
#include "tools/bags/bag_index.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

// Values of the field "op".
constexpr char kBagHeader = 3, kIndexData = 4, kChunk = 5, kChunkInfo = 6, kConnection = 7;
constexpr std::uint32_t kIndexEntry = 12, kChunkInfoEntry = 8;  // [bytes]
constexpr std::uint32_t kLongestHeader = 1 << 20;

using Fields = std::map<std::string, std::string>;
using Counts = std::map<std::uint32_t, std::uint64_t>;  // messages of each connection

class RecordFile {
 public:
  explicit RecordFile(const std::string& path) : file_(path, std::ios::binary) {
    file_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(file_.tellg());
    file_.seekg(static_cast<std::streamoff>(std::strlen("#ROSBAG V2.0\n")));
  }

  // False at the end of the file. Then `data_size` bytes follow.
  bool next(Fields* fields, std::uint32_t* data_size) {
    if (static_cast<std::uint64_t>(file_.tellg()) == size_) return false;
    const std::uint32_t header_size = number();
    if (header_size > kLongestHeader) fail();
    *fields = split(bytes(header_size));
    *data_size = number();
    if (*data_size > size_ - static_cast<std::uint64_t>(file_.tellg())) fail();
    return true;
  }
  void skip(std::uint32_t size) { file_.seekg(size, std::ios::cur); }
  std::string bytes(std::uint32_t size) {
    std::string text(size, '\0');
    if (!file_.read(text.data(), size)) fail();
    return text;
  }
  std::uint32_t number() { return numberAt(bytes(sizeof(std::uint32_t)), 0); }

  [[noreturn]] static void fail() { throw std::runtime_error("its records do not fit together"); }

  static std::uint32_t numberAt(const std::string& text, std::size_t at) {
    std::uint32_t value = 0;
    if (at + sizeof value > text.size()) fail();
    std::memcpy(&value, text.data() + at, sizeof value);
    return value;
  }

 private:
  static Fields split(const std::string& header) {
    Fields fields;
    for (std::size_t at = 0; at < header.size();) {
      const std::uint32_t size = numberAt(header, at);
      at += sizeof size;
      if (size > header.size() - at) fail();
      const std::string field = header.substr(at, size);
      const std::size_t equals = field.find('=');
      if (equals == std::string::npos) fail();
      fields[field.substr(0, equals)] = field.substr(equals + 1);
      at += size;
    }
    return fields;
  }

  std::ifstream file_;
  std::uint64_t size_ = 0;
};

}  // namespace

void checkBagIndex(const std::string& path) {
  RecordFile file(path);
  std::map<char, std::uint64_t> records;  // by op
  std::uint64_t chunks = 0, connections = 0;
  Counts in_indices, in_chunk_list;
  Fields fields;
  std::uint32_t size = 0;
  while (file.next(&fields, &size)) {
    const std::string op = fields["op"];
    if (op.size() != 1) RecordFile::fail();
    ++records[op[0]];
    const std::string data = op[0] == kChunkInfo ? file.bytes(size) : "";
    if (op[0] != kChunkInfo) file.skip(size);
    if (op[0] == kBagHeader) {
      chunks = RecordFile::numberAt(fields["chunk_count"], 0);
      connections = RecordFile::numberAt(fields["conn_count"], 0);
    } else if (op[0] == kIndexData) {
      const std::uint64_t count = RecordFile::numberAt(fields["count"], 0);
      if (size != count * kIndexEntry) RecordFile::fail();
      in_indices[RecordFile::numberAt(fields["conn"], 0)] += count;
    } else if (op[0] == kChunkInfo) {
      const std::uint64_t count = RecordFile::numberAt(fields["count"], 0);
      if (size != count * kChunkInfoEntry) RecordFile::fail();
      for (std::size_t at = 0; at < data.size(); at += kChunkInfoEntry) {
        in_chunk_list[RecordFile::numberAt(data, at)] += RecordFile::numberAt(data, at + 4);
      }
    }
  }
  if (in_indices != in_chunk_list || records[kChunk] != chunks || records[kChunkInfo] != chunks ||
      records[kConnection] != connections) {
    throw std::runtime_error("what it says about itself does not agree");
  }
}

}  // namespace deformable_contact_monitor
