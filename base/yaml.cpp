#include "base/yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "base/files.hpp"

namespace kantaro {
namespace {

constexpr std::size_t kLargestYaml = std::size_t{64} << 20;
constexpr int kDeepestNesting = 64;
constexpr int kMostValues = 4'000'000;  // their tree takes 1.9 GB

/// A first pass over the events alone, before any tree is built from a hostile file.
class Gatekeeper : public YAML::EventHandler {
 public:
  explicit Gatekeeper(const std::filesystem::path& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { Admit(mark, anchor); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { Admit(mark, 1); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string&) override {
    Admit(mark, anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Enter(mark, anchor);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Enter(mark, anchor);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void Admit(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (++values_ > kMostValues) {
      throw InputError(file_, mark.line + 1, "",
                       fmt::format("holds more than {} values", kMostValues));
    }
    if (anchor != 0) {
      throw InputError(file_, mark.line + 1, "",
                       "anchors and aliases are not accepted, write the value out");
    }
  }
  void Enter(const YAML::Mark& mark, YAML::anchor_t anchor) {
    Admit(mark, anchor);
    if (++depth_ > kDeepestNesting) {
      throw InputError(file_, mark.line + 1, "",
                       fmt::format("nested deeper than {} levels", kDeepestNesting));
    }
  }

  const std::filesystem::path& file_;
  int depth_ = 0;
  int values_ = 0;
};

int LineOf(const YAML::Node& node) { return node.Mark().line + 1; }

std::string Join(const std::vector<std::string_view>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace

YamlNode YamlNode::Load(const std::filesystem::path& file) {
  return Parse(ReadInputFile(file, kLargestYaml), file);
}

YamlNode YamlNode::Parse(const std::string& text, const std::filesystem::path& name) {
  const auto control = std::find_if(text.begin(), text.end(), [](unsigned char c) {
    return c < 0x20 && c != '\n' && c != '\r' && c != '\t';
  });
  if (control != text.end()) {
    const auto line = static_cast<int>(std::count(text.begin(), control, '\n')) + 1;
    throw InputError(name, line, "", "holds a control character, so it is no YAML text");
  }
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Gatekeeper gatekeeper(name);
    parser.HandleNextDocument(gatekeeper);
    if (parser.HandleNextDocument(gatekeeper)) {
      throw InputError(name, {}, "", "one document is wanted, more stand here");
    }
    YAML::Node root = YAML::Load(text);
    if (!root.IsDefined() || root.IsNull()) throw InputError(name, {}, "", "the file is empty");
    return YamlNode(root, name, "", LineOf(root));
  } catch (const YAML::Exception& error) {
    const std::optional<int> line =
        error.mark.is_null() ? std::nullopt : std::optional<int>(error.mark.line + 1);
    throw InputError(name, line, "", "not valid YAML: " + error.msg);
  }
}

InputError YamlNode::Error(const std::string& problem) const {
  return InputError(file_, line_, field_, problem);
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::Entries() const {
  if (!node_.IsMap()) throw Error("a map of keys is wanted here");
  std::vector<std::pair<std::string, YamlNode>> entries;
  std::set<std::string> seen;
  for (const auto& item : node_) {
    if (!item.first.IsScalar()) throw Error("keys must be plain words");
    const std::string key = item.first.Scalar();
    // yaml-cpp places an absent value at whatever comes after it.
    const int line = LineOf(item.second.IsNull() ? item.first : item.second);
    YamlNode value(item.second, file_, field_.empty() ? key : field_ + "." + key, line);
    if (!seen.insert(key).second) throw value.Error("the key stands here twice");
    entries.emplace_back(key, std::move(value));
  }
  return entries;
}

std::optional<YamlNode> YamlNode::Find(std::string_view key) const {
  for (auto& [name, value] : Entries()) {
    if (name == key) return value;
  }
  return std::nullopt;
}

YamlNode YamlNode::operator[](std::string_view key) const {
  if (auto found = Find(key)) return *found;
  throw Error(fmt::format("the key \"{}\" is missing", key));
}

void YamlNode::AllowOnly(std::initializer_list<std::string_view> allowed) const {
  for (const auto& [name, value] : Entries()) {
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end()) {
      throw value.Error(
          fmt::format("unknown key; known here: {}", Join({allowed.begin(), allowed.end()})));
    }
  }
}

std::vector<YamlNode> YamlNode::Elements() const {
  if (!node_.IsSequence()) throw Error("a list is wanted here");
  std::vector<YamlNode> elements;
  elements.reserve(node_.size());
  for (const auto& item : node_) {
    const std::string field = fmt::format("{}[{}]", field_, elements.size());
    elements.push_back(YamlNode(item, file_, field, LineOf(item)));
  }
  return elements;
}

std::string YamlNode::Text() const {
  if (!node_.IsScalar() || node_.Scalar().empty()) throw Error("a word is wanted here");
  return node_.Scalar();
}

bool YamlNode::Boolean() const {
  const std::string text = Text();
  if (text == "true") return true;
  if (text == "false") return false;
  throw Error(fmt::format("\"{}\" is neither true nor false", text));
}

double YamlNode::Number() const {
  if (!node_.IsScalar()) throw Error("a number is wanted here");
  const std::string& text = node_.Scalar();
  double value = 0.0;
  const bool plus = text.starts_with('+') && !text.starts_with("+-");
  const char* first = text.data() + (plus ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error(fmt::format("\"{}\" is not a number", text.substr(0, 40)));
  }
  return value;
}

double YamlNode::Number(double low, double high) const {
  const double value = Number();
  if (value < low || value > high)
    throw Error(fmt::format("{} is outside {} to {}", value, low, high));
  return value;
}

double YamlNode::Positive() const {
  const double value = Number();
  if (value <= 0.0) throw Error(fmt::format("{} must be above 0", value));
  return value;
}

long YamlNode::Integer(long low, long high) const {
  if (!node_.IsScalar()) throw Error("a whole number is wanted here");
  const std::string& text = node_.Scalar();
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw Error(fmt::format("\"{}\" is not a whole number", text.substr(0, 40)));
  }
  if (value < low || value > high)
    throw Error(fmt::format("{} is outside {} to {}", value, low, high));
  return value;
}

std::vector<double> YamlNode::Numbers(std::size_t count) const {
  std::vector<double> numbers;
  for (const YamlNode& element : Elements()) numbers.push_back(element.Number());
  if (numbers.size() != count) {
    throw Error(fmt::format("{} numbers are wanted here, {} stand here", count, numbers.size()));
  }
  return numbers;
}

}  // namespace kantaro
