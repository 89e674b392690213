#pragma once

#include "scenarios/conditions.hpp"
#include "sim/twin.hpp"

namespace kantaro::scenarios {

/// A seed's conditions in the twin's words, with the laser's mast set for the scenario's route.
[[nodiscard]] sim::Conditions TwinConditions(const Scenario& scenario,
                                             const Conditions& conditions);

}  // namespace kantaro::scenarios
