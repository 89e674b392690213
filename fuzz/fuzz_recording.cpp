// A bag from a person: read to its end, or refused.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <sstream>

#include "base/input_error.hpp"
#include "robot/recording/recording.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    kantaro::robot::Recording recording(std::make_unique<std::istringstream>(
                                            std::string(reinterpret_cast<const char*>(data), size)),
                                        "fuzz.bag");
    while (recording.Next()) {
    }
  } catch (const kantaro::InputError&) {
    // refused
  }
  return 0;
}
