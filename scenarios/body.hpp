#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "robot/description.hpp"
#include "robot/hardware.hpp"
#include "scenarios/conditions.hpp"
#include "scenarios/scenario.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {

/// What a mission drives: hardware, and what is really so where somebody knows.
struct Body {
  std::unique_ptr<robot::Hardware> hardware;
  /// Empty for a recording and for a device. Indices are those of the scenario's network.
  std::function<sim::GroundTruth()> truth;
};

/// A back end by its word on the command line: "sim", or "KIND:FILE".
struct HardwareChoice {
  std::string kind{"sim"};
  std::filesystem::path file;  ///< empty for "sim"
};

/// @throws InputError (file "--hardware") naming the kinds that are known.
[[nodiscard]] HardwareChoice ParseHardware(const std::string& word);

/// @param scenario  already cut to the surroundings of its route.
/// @throws InputError for a bad file. @throws sim::RenderingUnavailable
[[nodiscard]] Body MakeBody(const HardwareChoice& choice, const Scenario& scenario,
                            const Conditions& conditions, const robot::Description& description,
                            int render_threads);

}  // namespace kantaro::scenarios
