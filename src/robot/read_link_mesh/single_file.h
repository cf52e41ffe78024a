// All the files that Assimp may see: one.
#pragma once

#include <assimp/MemoryIOWrapper.h>

#include <assimp/IOSystem.hpp>
#include <cstdint>
#include <string>
#include <utility>

namespace deformable_contact_monitor {

// Materials, textures and whatever else a mesh file names are not there. They say nothing about
// its shape, and might be anything: another's secret, a FIFO, a device.
class SingleFile : public Assimp::IOSystem {
 public:
  // `bytes` must outlive this.
  SingleFile(std::string name, const std::string& bytes) : name_(std::move(name)), bytes_(bytes) {}

  bool Exists(const char* name) const override { return name == name_; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (name != name_ || *mode != 'r') return nullptr;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                      bytes_.size());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::string name_;
  const std::string& bytes_;
};

}  // namespace deformable_contact_monitor
