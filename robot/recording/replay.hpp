#pragma once

#include <cstddef>
#include <vector>

#include "robot/hardware.hpp"
#include "robot/recording/recording.hpp"

namespace kantaro::robot {

/// A recording as hardware: the readings of a robot that was told what it was told. A command is
/// honoured (or limited) if the same was given to it after the same reading, and refused otherwise:
/// the recording goes its own way. Stop() ends it.
class Replay : public Hardware {
 public:
  /// What the recording holds after one reading and before the next.
  struct Answer {
    std::vector<RecordedCommand> commands;
    std::vector<RecordedEstimate> estimates;
    std::vector<RecordedEvent> events;
    bool last{};  ///< no reading follows: it may be cut off before the commands that did
  };

  /// @throws InputError from Read(), too, for a file that turns out to be damaged.
  explicit Replay(Recording recording);

  [[nodiscard]] std::optional<Reading> Read() override;
  CommandOutcome Apply(const Command& command) override;
  void Stop() override { stopped_ = true; }
  [[nodiscard]] RunTime Now() const override { return now_; }

  [[nodiscard]] const Recording& recording() const { return recording_; }
  /// To the reading handed over last.
  [[nodiscard]] const Answer& answer() const { return answer_; }

 private:
  Recording recording_;
  std::optional<Reading> next_;
  Answer answer_;
  std::size_t applied_{};  ///< commands since the last reading
  RunTime now_{};
  bool stopped_{};
};

/// To the bit. @pre no NaN
[[nodiscard]] bool SameBits(const Command& a, const Command& b);

}  // namespace kantaro::robot
