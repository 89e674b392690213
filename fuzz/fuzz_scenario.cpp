// Whatever stands in a scenario file, it is read or refused with an InputError.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/input_error.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/scenario.hpp"

namespace {

using kantaro::network::Manhole;
using kantaro::network::Network;
using kantaro::network::Pipe;

Manhole MakeManhole(const std::string& name, double x_m, double y_m) {
  Manhole manhole;
  manhole.name = name;
  manhole.p_WM = {x_m, y_m, 0.0};
  return manhole;
}

Pipe MakePipe(const std::string& name, const std::string& upstream, const std::string& downstream,
              double diameter_m) {
  Pipe pipe;
  pipe.name = name;
  pipe.upstream = upstream;
  pipe.downstream = downstream;
  pipe.diameter_m = diameter_m;
  return pipe;
}

/// A tee, one of whose arms is too narrow for the robot.
const Network& Tee() {
  static const Network network = [] {
    Network tee;
    tee.manholes = {MakeManhole("S", 0.0, 0.0), MakeManhole("M", 5.0, 0.0),
                    MakeManhole("E", 10.0, 0.0), MakeManhole("N", 5.0, 5.0)};
    tee.pipes = {MakePipe("P1", "S", "M", 0.3), MakePipe("P2", "M", "E", 0.25),
                 MakePipe("P3", "M", "N", 0.15)};
    return tee;
  }();
  return network;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const auto scenario = kantaro::scenarios::ParseScenario(
        text, "scenario.yaml", [](const std::filesystem::path&) { return Tee(); });
    static_cast<void>(kantaro::scenarios::DrawConditions(scenario, 1));
  } catch (const kantaro::InputError&) {
  }
  return 0;
}
