#include <cstddef>
#include <cstdint>
#include <string>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "robot/description.hpp"

namespace {

using kantaro::robot::SourceText;

SourceText Shipped(const char* name) {
  return {name, kantaro::ReadInputFile(std::filesystem::path(KANTARO_SOURCE_DIR) /
                                       "models/kantaro" / name)};
}

}  // namespace

/// Any URDF text beside the shipped companion files: a robot, or an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SourceText companion = Shipped("kantaro.yaml");
  static const SourceText cameras = Shipped("cameras.yaml");
  try {
    (void)kantaro::robot::ParseDescription(
        {"input", std::string(reinterpret_cast<const char*>(data), size)}, companion, cameras);
  } catch (const kantaro::InputError&) {
  }
  return 0;
}
