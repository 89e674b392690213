#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

namespace kantaro {

/// Bad input from a person: a file or an argument. The program prints it as one sentence and exits
/// with 2. what() reads "FILE:LINE: FIELD: PROBLEM", leaving out the parts that are not known.
class InputError : public std::runtime_error {
 public:
  /// @param file     the file, or the name of the argument ("--seed").
  /// @param line     1-based; absent if the trouble is not on one line.
  /// @param field    the key or column, e.g. "pipes[3].diameter_mm"; may be empty.
  /// @param problem  what is wrong and what would be right, one sentence without a full stop.
  InputError(const std::filesystem::path& file, std::optional<int> line, std::string field,
             const std::string& problem);

  [[nodiscard]] const std::string& field() const { return field_; }
  [[nodiscard]] std::optional<int> line() const { return line_; }

 private:
  std::string field_;
  std::optional<int> line_;
};

}  // namespace kantaro
