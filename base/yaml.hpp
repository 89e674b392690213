#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_error.hpp"

namespace kantaro {

/// A node of a YAML file that knows where it stands, so that every complaint names file, line and
/// field. Strict: a scalar of the wrong type, a missing key or an unknown one is an InputError;
/// nothing is guessed. Cheap to copy; keeps its document alive.
class YamlNode {
 public:
  /// Parses one document. Refuses anchors and aliases (a few lines can name billions of nodes),
  /// a second document, duplicate keys, nesting deeper than 64, eight million values, and
  /// files above 128 MiB.
  /// @throws InputError
  [[nodiscard]] static YamlNode Load(const std::filesystem::path& file);
  [[nodiscard]] static YamlNode Parse(const std::string& text, const std::filesystem::path& name);

  /// The value of a key of this map. @throws InputError if absent, or this is no map.
  [[nodiscard]] YamlNode operator[](std::string_view key) const;
  /// The same, absent if the key is.
  [[nodiscard]] std::optional<YamlNode> Find(std::string_view key) const;
  /// @throws InputError naming the first key that is not in `allowed`, and what is.
  void AllowOnly(std::initializer_list<std::string_view> allowed) const;

  /// Elements of this sequence. @throws InputError if it is none.
  [[nodiscard]] std::vector<YamlNode> Elements() const;
  /// Keys of this map in the file's order, each with its value. @throws InputError if it is none.
  [[nodiscard]] std::vector<std::pair<std::string, YamlNode>> Entries() const;

  [[nodiscard]] std::string Text() const;                      ///< a scalar, not empty
  [[nodiscard]] bool Boolean() const;                          ///< true or false
  [[nodiscard]] double Number() const;                         ///< finite
  [[nodiscard]] double Number(double low, double high) const;  ///< low <= value <= high
  [[nodiscard]] double Positive() const;                       ///< > 0
  [[nodiscard]] long Integer(long low, long high) const;
  /// Exactly `count` finite numbers.
  [[nodiscard]] std::vector<double> Numbers(std::size_t count) const;

  [[nodiscard]] bool IsMap() const;
  [[nodiscard]] bool IsSequence() const;
  /// The way to it from the root, "pipes[3].diameter_mm".
  [[nodiscard]] std::string field() const;
  [[nodiscard]] const std::filesystem::path& file() const;
  [[nodiscard]] int line() const;

  /// The error to throw about this node.
  [[nodiscard]] InputError Error(const std::string& problem) const;

 private:
  struct Document;
  class TreeBuilder;
  YamlNode(std::shared_ptr<const Document> document, std::uint32_t index)
      : document_(std::move(document)), index_(index) {}
  [[nodiscard]] YamlNode At(std::uint32_t index) const { return {document_, index}; }
  [[nodiscard]] std::string_view Scalar() const;
  [[nodiscard]] bool IsScalar() const;
  void DemandMap() const;

  std::shared_ptr<const Document> document_;
  std::uint32_t index_;
};

}  // namespace kantaro
