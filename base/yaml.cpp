#include "base/yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/files.hpp"

namespace kantaro {
namespace {

constexpr std::size_t kLargestYaml = std::size_t{128} << 20;
constexpr int kDeepestNesting = 64;
constexpr std::size_t kMostValues = 8'000'000;  // their tree takes 320 MB
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

enum class Kind : std::uint8_t { kNull, kScalar, kSequence, kMap };

std::string Join(const std::vector<std::string_view>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace

/// The whole file in two blocks of memory: a city has millions of values.
struct YamlNode::Document {
  /// A value. Keys of maps are not nodes of their own: they are kept with their values.
  struct Node {
    std::uint32_t parent{kNone};
    std::uint32_t next{kNone};   ///< the parent's next child
    std::uint32_t child{kNone};  ///< the first, if it is a sequence or a map
    std::uint32_t count{};       ///< of children; of bytes, if it is a scalar
    std::uint32_t text{};        ///< where a scalar's bytes begin
    std::uint32_t key{};         ///< where the key's bytes begin, in a map
    std::uint32_t key_size{};
    std::uint32_t place{};  ///< among the parent's children
    std::int32_t line{};
    Kind kind{Kind::kNull};
  };

  std::filesystem::path file;
  std::vector<Node> nodes;
  std::string text;

  [[nodiscard]] std::string_view Scalar(const Node& node) const {
    return std::string_view(text).substr(node.text, node.count);
  }
  [[nodiscard]] std::string_view Key(const Node& node) const {
    return std::string_view(text).substr(node.key, node.key_size);
  }
};

/// Makes the tree from the parser's events, and refuses what no file of ours needs before it takes
/// up memory.
class YamlNode::TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(Document& document) : document_(document) {}

  void OnDocumentStart(const YAML::Mark&) override {
    if (++documents_ > 1) {
      throw InputError(document_.file, {}, "", "one document is wanted, more stand here");
    }
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    // yaml-cpp places an absent value at whatever comes after it.
    const int line = key_ ? key_->line : mark.line + 1;
    Admit(mark, anchor);
    if (ExpectsKey()) RefuseKey();
    Add(Kind::kNull, line);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { Admit(mark, 1); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& value) override {
    Admit(mark, anchor);
    const auto start = static_cast<std::uint32_t>(document_.text.size());
    document_.text += value;
    const auto size = static_cast<std::uint32_t>(value.size());
    if (ExpectsKey()) {
      key_ = PendingKey{start, size, mark.line + 1};
      return;
    }
    Document::Node& node = Add(Kind::kScalar, mark.line + 1);
    node.text = start;
    node.count = size;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Enter(mark, anchor, Kind::kSequence);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Enter(mark, anchor, Kind::kMap);
  }
  void OnMapEnd() override {
    RefuseTwins(open_.back().node);
    open_.pop_back();
  }

 private:
  struct PendingKey {
    std::uint32_t start, size;
    int line;
  };
  struct Open {
    std::uint32_t node, last_child;
  };

  [[nodiscard]] bool ExpectsKey() const {
    return !open_.empty() && document_.nodes[open_.back().node].kind == Kind::kMap && !key_;
  }

  void Admit(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (++values_ > kMostValues) {
      throw InputError(document_.file, mark.line + 1, "",
                       fmt::format("holds more than {} values", kMostValues));
    }
    if (anchor != 0) {
      throw InputError(document_.file, mark.line + 1, "",
                       "anchors and aliases are not accepted, write the value out");
    }
  }

  [[noreturn]] void RefuseKey() const {
    throw YamlNode(Borrowed(), open_.back().node).Error("keys must be plain words");
  }

  /// Complains about a key that stands in a map before: at the value after the later one.
  void RefuseTwins(std::uint32_t map) const {
    std::vector<std::pair<std::string_view, std::uint32_t>> keys;
    for (std::uint32_t i = document_.nodes[map].child; i != kNone; i = document_.nodes[i].next) {
      keys.emplace_back(document_.Key(document_.nodes[i]), i);
    }
    std::sort(keys.begin(), keys.end());
    std::uint32_t first = kNone;
    for (std::size_t i = 1; i < keys.size(); ++i) {
      if (keys[i].first == keys[i - 1].first) first = std::min(first, keys[i].second);
    }
    if (first != kNone) throw YamlNode(Borrowed(), first).Error("the key stands here twice");
  }

  void Enter(const YAML::Mark& mark, YAML::anchor_t anchor, Kind kind) {
    Admit(mark, anchor);
    if (ExpectsKey()) RefuseKey();
    if (open_.size() >= kDeepestNesting) {
      throw InputError(document_.file, mark.line + 1, "",
                       fmt::format("nested deeper than {} levels", kDeepestNesting));
    }
    Add(kind, mark.line + 1);
    open_.push_back({static_cast<std::uint32_t>(document_.nodes.size() - 1), kNone});
  }

  Document::Node& Add(Kind kind, int line) {
    const auto index = static_cast<std::uint32_t>(document_.nodes.size());
    Document::Node& node = document_.nodes.emplace_back();
    node.kind = kind;
    node.line = line;
    if (key_) {
      node.key = key_->start;
      node.key_size = key_->size;
      key_.reset();
    }
    if (open_.empty()) return node;
    Open& open = open_.back();
    node.parent = open.node;
    node.place = document_.nodes[open.node].count++;
    (open.last_child == kNone ? document_.nodes[open.node].child
                              : document_.nodes[open.last_child].next) = index;
    open.last_child = index;
    return node;
  }

  /// The document as an error sees it while it is being made.
  [[nodiscard]] std::shared_ptr<const Document> Borrowed() const {
    return {std::shared_ptr<const Document>(), &document_};
  }

  Document& document_;
  std::vector<Open> open_;
  std::optional<PendingKey> key_;
  std::size_t values_{};
  int documents_{};
};

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
  const auto document = std::make_shared<Document>();
  document->file = name;
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    TreeBuilder builder(*document);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    const std::optional<int> line =
        error.mark.is_null() ? std::nullopt : std::optional<int>(error.mark.line + 1);
    throw InputError(name, line, "", "not valid YAML: " + error.msg);
  }
  if (document->nodes.empty() || document->nodes.front().kind == Kind::kNull) {
    throw InputError(name, {}, "", "the file is empty");
  }
  return {document, 0};
}

InputError YamlNode::Error(const std::string& problem) const {
  return InputError(file(), line(), field(), problem);
}

bool YamlNode::IsMap() const { return document_->nodes[index_].kind == Kind::kMap; }
bool YamlNode::IsScalar() const { return document_->nodes[index_].kind == Kind::kScalar; }
bool YamlNode::IsSequence() const { return document_->nodes[index_].kind == Kind::kSequence; }
const std::filesystem::path& YamlNode::file() const { return document_->file; }
int YamlNode::line() const { return document_->nodes[index_].line; }

std::string YamlNode::field() const {
  const Document::Node& node = document_->nodes[index_];
  if (node.parent == kNone) return "";
  const std::string above = At(node.parent).field();
  if (document_->nodes[node.parent].kind == Kind::kSequence) {
    return fmt::format("{}[{}]", above, node.place);
  }
  return fmt::format("{}{}{}", above, above.empty() ? "" : ".", document_->Key(node));
}

/// Empty if it is no scalar.
std::string_view YamlNode::Scalar() const {
  const Document::Node& node = document_->nodes[index_];
  return node.kind == Kind::kScalar ? document_->Scalar(node) : std::string_view();
}

void YamlNode::DemandMap() const {
  if (!IsMap()) throw Error("a map of keys is wanted here");
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::Entries() const {
  DemandMap();
  std::vector<std::pair<std::string, YamlNode>> entries;
  const auto& nodes = document_->nodes;
  for (std::uint32_t i = nodes[index_].child; i != kNone; i = nodes[i].next) {
    entries.emplace_back(document_->Key(nodes[i]), At(i));
  }
  return entries;
}

std::optional<YamlNode> YamlNode::Find(std::string_view key) const {
  DemandMap();
  const auto& nodes = document_->nodes;
  for (std::uint32_t i = nodes[index_].child; i != kNone; i = nodes[i].next) {
    if (document_->Key(nodes[i]) == key) return At(i);
  }
  return std::nullopt;
}

YamlNode YamlNode::operator[](std::string_view key) const {
  if (auto found = Find(key)) return *found;
  throw Error(fmt::format("the key \"{}\" is missing", key));
}

void YamlNode::AllowOnly(std::initializer_list<std::string_view> allowed) const {
  DemandMap();
  const auto& nodes = document_->nodes;
  for (std::uint32_t i = nodes[index_].child; i != kNone; i = nodes[i].next) {
    if (std::find(allowed.begin(), allowed.end(), document_->Key(nodes[i])) == allowed.end()) {
      throw At(i).Error(
          fmt::format("unknown key; known here: {}", Join({allowed.begin(), allowed.end()})));
    }
  }
}

std::vector<YamlNode> YamlNode::Elements() const {
  if (!IsSequence()) throw Error("a list is wanted here");
  std::vector<YamlNode> elements;
  const auto& nodes = document_->nodes;
  elements.reserve(nodes[index_].count);
  for (std::uint32_t i = nodes[index_].child; i != kNone; i = nodes[i].next) {
    elements.push_back(At(i));
  }
  return elements;
}

std::string YamlNode::Text() const {
  if (Scalar().empty()) throw Error("a word is wanted here");
  return std::string(Scalar());
}

bool YamlNode::Boolean() const {
  const std::string text = Text();
  if (text == "true") return true;
  if (text == "false") return false;
  throw Error(fmt::format("\"{}\" is neither true nor false", text));
}

double YamlNode::Number() const {
  if (!IsScalar()) throw Error("a number is wanted here");
  const std::string_view text = Scalar();
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
  if (!IsScalar()) throw Error("a whole number is wanted here");
  const std::string_view text = Scalar();
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
