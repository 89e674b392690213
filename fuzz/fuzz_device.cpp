// Whatever stands in a device's configuration, it is read or refused with an InputError.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/input_error.hpp"
#include "robot/device/config.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    static_cast<void>(kantaro::robot::ParseDeviceConfig(
        std::string(reinterpret_cast<const char*>(data), size), "device.yaml"));
  } catch (const kantaro::InputError&) {
  }
  return 0;
}
