#pragma once

#include "perception/observations.hpp"
#include "robot/readings.hpp"

namespace kantaro::perception {

/// How the IR sensors are read (thesis 4.3, figs 4.7 and 4.8).
struct IrParameters {
  double manhole_threshold{0.25};   ///< of IR-1, up: below it the crown is gone
  double junction_threshold{0.25};  ///< of the side sensors: below it the side wall is gone
  int readings{3};                  ///< a state changes after so many readings in a row
};

/// Manholes and junctions from the three IR sensors: a value *below* its threshold means that the
/// wall is gone, for the value falls with distance (thesis 4.3). A side inlet opens a side as a
/// junction does: IR alone cannot tell them apart, the map or the laser's top window can. Starts
/// inside a pipe: nothing detected.
class IrLandmarks {
 public:
  /// @throws std::invalid_argument if readings < 1.
  explicit IrLandmarks(const IrParameters& parameters);

  /// Takes the next reading and returns the settled state.
  [[nodiscard]] IrObservation Update(const robot::IrRanges& ranges, robot::RunTime captured_at);

 private:
  struct Sensor {
    bool open{};
    int run{};  ///< readings in a row that disagree with `open`
  };
  bool Settle(Sensor& sensor, bool open) const;

  IrParameters parameters_;
  Sensor up_, left_, right_;
};

}  // namespace kantaro::perception
