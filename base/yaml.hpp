#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_error.hpp"

namespace kantaro {

/// A node of a YAML file that knows where it stands, so that every complaint names file, line and
/// field. Strict: a scalar of the wrong type, a missing key or an unknown one is an InputError;
/// nothing is guessed.
class YamlNode {
 public:
  /// Parses one document. Refuses anchors and aliases (a few lines can name billions of nodes),
  /// a second document, duplicate keys, nesting deeper than 64, four million values, and files
  /// above 64 MiB.
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

  [[nodiscard]] bool IsMap() const { return node_.IsMap(); }
  [[nodiscard]] bool IsSequence() const { return node_.IsSequence(); }
  [[nodiscard]] const std::string& field() const { return field_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] int line() const { return line_; }

  /// The error to throw about this node.
  [[nodiscard]] InputError Error(const std::string& problem) const;

 private:
  YamlNode(YAML::Node node, std::filesystem::path file, std::string field, int line)
      : node_(std::move(node)), file_(std::move(file)), field_(std::move(field)), line_(line) {}

  YAML::Node node_;
  std::filesystem::path file_;
  std::string field_;
  int line_;
};

}  // namespace kantaro
