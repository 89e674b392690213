// Any bytes are a table of grips in which less water never grips less, or an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/input_error.hpp"
#include "sim/grip.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const auto table = kantaro::sim::ParseGripTable(text, "materials.yaml");
    for (const auto& conditions : table.grips) {
      double before = HUGE_VAL;
      for (const kantaro::sim::Grip& grip : conditions) {
        if (!(grip.tyre_friction > 0.0 && grip.tyre_friction <= before)) std::abort();
        before = grip.tyre_friction;
      }
    }
  } catch (const kantaro::InputError&) {
  }
  return 0;
}
