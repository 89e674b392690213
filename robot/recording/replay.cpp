#include "robot/recording/replay.hpp"

#include <cstring>
#include <utility>

namespace kantaro::robot {

bool SameBits(const Command& a, const Command& b) {
  static_assert(sizeof(Command) == 3 * sizeof(double));
  return std::memcmp(&a, &b, sizeof a) == 0;
}

Replay::Replay(Recording recording) : recording_(std::move(recording)) {
  // What stands before the first reading was nobody's answer to one.
  while (const std::optional<Record> record = recording_.Next()) {
    if (const auto* reading = std::get_if<Reading>(&*record)) {
      next_ = *reading;
      break;
    }
  }
}

std::optional<Reading> Replay::Read() {
  if (stopped_ || !next_) return std::nullopt;
  Reading reading = *std::exchange(next_, std::nullopt);
  now_ = reading.arrived_at;
  answer_ = {};
  applied_ = 0;
  while (!next_) {
    std::optional<Record> record = recording_.Next();
    if (!record) break;
    if (auto* command = std::get_if<RecordedCommand>(&*record)) {
      answer_.commands.push_back(*command);
    } else if (auto* estimate = std::get_if<RecordedEstimate>(&*record)) {
      answer_.estimates.push_back(std::move(*estimate));
    } else if (auto* event = std::get_if<RecordedEvent>(&*record)) {
      answer_.events.push_back(std::move(*event));
    } else {
      next_ = std::move(std::get<Reading>(*record));
    }
  }
  answer_.last = !next_;
  return reading;
}

CommandOutcome Replay::Apply(const Command& command) {
  CheckCommand(command);
  if (stopped_ || applied_ >= answer_.commands.size()) return CommandOutcome::kRefused;
  const RecordedCommand& recorded = answer_.commands[applied_++];
  return SameBits(command, recorded.command) ? recorded.outcome : CommandOutcome::kRefused;
}

}  // namespace kantaro::robot
