#include "robot/device/continuity.hpp"

#include <algorithm>

namespace kantaro::robot {

std::optional<Reading> Continuity::Came(RunTime captured_at, std::uint32_t lost_before,
                                        RunTime now) {
  std::optional<Reading> loss;
  if (lost_before > reported_) loss = Report(lost_before - reported_, now);
  last_ = std::max(last_, captured_at);
  reported_ = 0;
  told_at_.reset();
  return loss;
}

std::optional<Reading> Continuity::Wait(RunTime now) {
  if (down_ || now - told_at_.value_or(last_) < patience_) return std::nullopt;
  const std::uint32_t due = Due(now);
  if (due <= reported_) return std::nullopt;
  told_at_ = now;
  return Report(due - reported_, now);
}

Reading Continuity::GoDown(RunTime now) {
  down_ = true;
  Reading loss = Report(std::max(Due(now), reported_) - reported_, now);
  std::get<Loss>(loss.value).line_down = true;
  return loss;
}

std::uint32_t Continuity::Due(RunTime now) const {
  return static_cast<std::uint32_t>(std::max<std::int64_t>(0, (now - last_) / period_));
}

Reading Continuity::Report(std::uint32_t more, RunTime now) {
  const RunTime due_at = last_ + (reported_ + 1) * period_;
  reported_ += more;
  return {std::min(due_at, now), now, Loss{sensor_, more, false}};
}

}  // namespace kantaro::robot
