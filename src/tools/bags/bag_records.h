// The records of a bag file, read without rosbag's library, which trusts what a bag says.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {

// A record is a header of named fields, and data.
using RecordFields = std::map<std::string, std::string>;

// Walks over the records of a bag. Every size is checked against the file's size.
class RecordFile {
 public:
  // Kinds of records, as http://wiki.ros.org/Bags/Format/2.0 defines them: values of the field
  // "op".
  static constexpr char kBagHeader = 3, kIndexData = 4, kChunk = 5, kChunkInfo = 6, kConnection = 7;
  static constexpr std::uint32_t kIndexEntry = 12;  // size of an entry in an index [bytes]

  explicit RecordFile(const std::string& path) : file_(path, std::ios::binary) {
    file_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(file_.tellg());
    file_.seekg(static_cast<std::streamoff>(std::strlen("#ROSBAG V2.0\n")));
  }

  // False at the end of the file. Then `data_size` bytes follow.
  bool next(RecordFields* fields, std::uint32_t* data_size) {
    if (static_cast<std::uint64_t>(file_.tellg()) == size_) return false;
    const std::uint32_t header_size = number();
    // Larger headers do not exist; a damaged size must not allocate memory.
    constexpr std::uint32_t kLongestHeader = 1 << 20;
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
  static RecordFields split(const std::string& header) {
    RecordFields fields;
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

// Compares the counts that a bag states with the records that are there. rosbag's library trusts
// the counts, so a damaged one would silently lose messages. Reads only the records' headers.
// Throws std::runtime_error, one line, if the two differ or a record does not end where it should.
void checkBagIndex(const std::string& path);

}  // namespace deformable_contact_monitor
