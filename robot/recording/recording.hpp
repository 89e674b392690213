#pragma once

#include <filesystem>
#include <istream>
#include <memory>
#include <optional>

#include "robot/description.hpp"
#include "robot/recording/records.hpp"

namespace kantaro::robot {

/// A recording by Recorder, read from beginning to end: every number and pixel as it was, in the
/// order in which it was written. Trusts nothing in the file.
class Recording {
 public:
  /// @throws InputError if the file is no bag, has no index, is cut off, or is not one of ours.
  explicit Recording(const std::filesystem::path& file);
  Recording(std::unique_ptr<std::istream> stream, const std::filesystem::path& name);
  ~Recording();
  Recording(Recording&&) noexcept;

  [[nodiscard]] const std::filesystem::path& file() const;
  [[nodiscard]] const MissionFiles& mission() const;
  /// The robot that was recorded.
  [[nodiscard]] const Description& description() const;

  /// The next record; absent at the end.
  /// @throws InputError for a message that is damaged or says what no hardware may say.
  [[nodiscard]] std::optional<Record> Next();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kantaro::robot
