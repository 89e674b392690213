#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_error.hpp"

// The text of an EPA SWMM file: sections, rows and words, before they mean anything.
namespace kantaro::network::swmm {

/// One row of a section. Its words point into the text.
struct Row {
  const std::filesystem::path* file;
  std::string_view section;
  int line;
  std::vector<std::string_view> words;

  [[nodiscard]] InputError Error(std::string_view column, const std::string& problem) const;
  /// @throws InputError if the row ends before it
  [[nodiscard]] std::string Word(std::size_t position, std::string_view column) const;
  /// @throws InputError likewise, and for what is empty, too long or not printable
  [[nodiscard]] std::string Name(std::size_t position, std::string_view column) const;
  /// @throws InputError likewise, and for words that are no number
  [[nodiscard]] double Number(std::size_t position, std::string_view column) const;
  [[nodiscard]] double Positive(std::size_t position, std::string_view column) const;
};

struct Text {
  std::map<std::string, std::vector<Row>, std::less<>> sections;  ///< that the reader wants
  std::vector<std::pair<int, std::string>> unknown;  ///< line and name of those SWMM has not

  /// None if there is no such section.
  [[nodiscard]] const std::vector<Row>& Rows(std::string_view section) const;
};

/// The file as UTF-8 with plain line ends. @throws InputError if it is no text.
[[nodiscard]] std::string Cleaned(const std::string& text, const std::filesystem::path& file);

/// Sections by their full names in capitals. As in SWMM a heading may be cut short ("[JUNC]") and
/// stand more than once. `text` and `file` must outlive the result. @throws InputError
[[nodiscard]] Text Split(std::string_view text, const std::filesystem::path& file);

[[nodiscard]] std::string Upper(std::string_view word);

/// The beginning of UTF-8 text, fit to be quoted in a remark: up to 60 bytes, none of them control
/// characters.
[[nodiscard]] std::string Quotable(std::string_view text);

}  // namespace kantaro::network::swmm
