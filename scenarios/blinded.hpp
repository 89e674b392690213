#pragma once

#include <optional>
#include <set>
#include <utility>

#include "robot/hardware.hpp"
#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {

/// Hardware some of whose sensors are dead: their readings never arrive. Everything else passes
/// through.
class Blinded : public robot::Hardware {
 public:
  /// The hardware must outlive this.
  Blinded(robot::Hardware& hardware, std::set<Sense> dead)
      : hardware_(hardware), dead_(std::move(dead)) {}

  [[nodiscard]] std::optional<robot::Reading> Read() override;
  robot::CommandOutcome Apply(const robot::Command& command) override {
    return hardware_.Apply(command);
  }
  void Stop() override { hardware_.Stop(); }
  [[nodiscard]] robot::RunTime Now() const override { return hardware_.Now(); }

 private:
  robot::Hardware& hardware_;
  std::set<Sense> dead_;
};

}  // namespace kantaro::scenarios
