#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "base/yaml.hpp"
#include "robot/description.hpp"
#include "robot/hardware.hpp"

namespace kantaro::robot {

/// What may be wrong with a sensor.
enum class FaultKind : std::uint8_t {
  kFrozen,     ///< says again and again what it said last
  kDropped,    ///< `amount`, 0 to 1, of its readings are lost, by chance
  kSaturated,  ///< stands at the end of its scale (Saturate says which)
  kBiased,     ///< is off by `amount` (Bias says in which unit)
  kDelayed,    ///< its readings arrive `amount` seconds later
  kDead        ///< says nothing any more
};
/// "frozen", "dropped", "saturated", "biased", "delayed", "dead".
[[nodiscard]] const char* ToString(FaultKind kind);

/// One thing wrong with one sensor, for some time.
struct Fault {
  Sensor sensor{};
  FaultKind kind{FaultKind::kDead};
  RunTime from{};                ///< readings captured from then on ...
  std::optional<RunTime> until;  ///< ... and before this; absent: for good
  std::uint64_t from_reading{
      1};  ///< and only from the n-th reading of the sensor on; 1 is the first
  double amount{};
};

/// "laser biased by 0.02 from 3.0 s": for reports.
[[nodiscard]] std::string ToString(const Fault& fault);

/// Reads a list of {sensor, kind, from_s?, until_s?, from_reading?, amount?}. `amount` belongs to
/// dropped, biased and delayed, and only to them. @throws InputError
[[nodiscard]] std::vector<Fault> ReadFaults(const YamlNode& list);

/// The sensors that a word names: one of ToString(Sensor), or "cameras", which are all of them;
/// empty for any other word.
[[nodiscard]] std::set<Sensor> SensorsNamed(const std::string& word);
/// All such words, for complaints: "front_camera, ..., battery, cameras".
[[nodiscard]] std::string SensorWords();

/// Puts a reading at the end of its sensor's scale: images white, a laser and a compass dazzled
/// (nothing returns; 45°, disturbed), IR at 1, encoders at their 32-bit counters' end, inertial
/// unit and inclinometer at their range, a battery that always looks full.
void Saturate(Reading& reading, const Description& description);

/// Adds to a reading: images in levels of 255; laser ranges in m (too near and too far follow); IR
/// in its own unit; encoders as a share of all they have turned; inertial: gyro in rad/s, each
/// axis; inclinometer and compass in rad; battery in V.
void Bias(Reading& reading, double amount, const Description& description);

/// Any hardware, with faults in its sensors. A reading that is lost is reported as a Loss in its
/// place. A delayed one is handed over with the first reading that arrives after it is due, so
/// arrival times still never decrease; one that is due after the run never arrives. Commands,
/// clock and the hardware's own losses pass through.
class Faulted : public Hardware {
 public:
  /// @param hardware  must outlive this. @param seed  of what chance decides.
  /// @throws std::invalid_argument for a probability outside 0 … 1, or a delay that is none.
  Faulted(Hardware& hardware, Description description, const std::vector<Fault>& faults,
          std::uint64_t seed);

  [[nodiscard]] std::optional<Reading> Read() override;
  CommandOutcome Apply(const Command& command) override { return hardware_.Apply(command); }
  void Stop() override { hardware_.Stop(); }
  [[nodiscard]] RunTime Now() const override { return hardware_.Now(); }

 private:
  struct Active {
    Fault fault;
    RandomStream chance;
    std::uint64_t readings{};     ///< of this sensor so far
    std::optional<Reading> last;  ///< before it froze
  };

  /// Does its damage if the fault is on. @returns the delay it adds.
  RunTime Spoil(Active& active, Reading& reading) const;
  /// Those that are due by now, in the order in which they were.
  void HandOverDelayed(RunTime now);

  Hardware& hardware_;
  Description description_;
  std::vector<Active> faults_;
  std::deque<Reading> ready_;
  std::vector<Reading> delayed_;  ///< `arrived_at` says when they are due
};

}  // namespace kantaro::robot
