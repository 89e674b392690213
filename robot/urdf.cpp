#include "robot/urdf.hpp"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "base/input_error.hpp"

namespace kantaro::robot {
namespace {

constexpr std::size_t kLargestUrdf = std::size_t{4} << 20;
constexpr std::size_t kMostLinks = 1000;
constexpr int kDeepestNesting = 16;     // URDF needs 6; TinyXML recurses without a limit of its own
constexpr double kLargestNumber = 1e6;  // beyond it squares and products lose their meaning
constexpr double kUnitTolerance = 1e-6;

enum class Kind { kWord, kNumber, kPositive, kVector, kPositiveVector, kDirection, kJointType };
enum class Count { kOptional, kOne, kMany };

struct AttributeRule {
  std::string_view name;
  Kind kind;
  bool required;
};

struct ChildRule {
  std::string_view name;
  Count count;
};

struct ElementRule {
  std::string_view name;
  std::vector<AttributeRule> attributes;
  std::vector<ChildRule> children;
};

/// The accepted part of URDF.
const std::vector<ElementRule>& Rules() {
  using enum Kind;
  using enum Count;
  static const std::vector<ElementRule> kRules{
      {"robot", {{"name", kWord, true}}, {{"link", kMany}, {"joint", kMany}}},
      {"link",
       {{"name", kWord, true}},
       {{"inertial", kOptional}, {"collision", kMany}, {"visual", kMany}}},
      {"inertial", {}, {{"origin", kOptional}, {"mass", kOne}, {"inertia", kOne}}},
      {"collision", {{"name", kWord, false}}, {{"origin", kOptional}, {"geometry", kOne}}},
      {"visual", {{"name", kWord, false}}, {{"origin", kOptional}, {"geometry", kOne}}},
      {"origin", {{"xyz", kVector, false}, {"rpy", kVector, false}}, {}},
      {"mass", {{"value", kPositive, true}}, {}},
      {"inertia",
       {{"ixx", kPositive, true},
        {"iyy", kPositive, true},
        {"izz", kPositive, true},
        {"ixy", kNumber, true},
        {"ixz", kNumber, true},
        {"iyz", kNumber, true}},
       {}},
      {"geometry", {}, {{"box", kOptional}, {"cylinder", kOptional}, {"sphere", kOptional}}},
      {"box", {{"size", kPositiveVector, true}}, {}},
      {"cylinder", {{"radius", kPositive, true}, {"length", kPositive, true}}, {}},
      {"sphere", {{"radius", kPositive, true}}, {}},
      {"joint",
       {{"name", kWord, true}, {"type", kJointType, true}},
       {{"origin", kOptional},
        {"parent", kOne},
        {"child", kOne},
        {"axis", kOptional},
        {"limit", kOptional}}},
      {"parent", {{"link", kWord, true}}, {}},
      {"child", {{"link", kWord, true}}, {}},
      {"axis", {{"xyz", kDirection, true}}, {}},
      {"limit",
       {{"lower", kNumber, true},
        {"upper", kNumber, true},
        {"effort", kNumber, true},
        {"velocity", kNumber, true}},
       {}},
  };
  return kRules;
}

const ElementRule& RuleNamed(std::string_view name) {
  return *std::find_if(Rules().begin(), Rules().end(),
                       [&](const ElementRule& rule) { return rule.name == name; });
}

template <typename Range>
std::string Names(const Range& rules) {
  std::vector<std::string_view> names;
  for (const auto& rule : rules) names.push_back(rule.name);
  return names.empty() ? "nothing" : fmt::format("{}", fmt::join(names, ", "));
}

InputError ErrorAt(const std::filesystem::path& file, const TiXmlBase& node, std::string field,
                   const std::string& problem) {
  const std::optional<int> line = node.Row() > 0 ? std::optional<int>(node.Row()) : std::nullopt;
  return InputError(file, line, std::move(field), problem);
}

std::vector<std::string_view> Words(std::string_view text) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlank = " \t\r\n";
  while (true) {
    const std::size_t first = text.find_first_not_of(kBlank);
    if (first == std::string_view::npos) return words;
    const std::size_t last = std::min(text.find_first_of(kBlank, first), text.size());
    words.push_back(text.substr(first, last - first));
    text.remove_prefix(last);
  }
}

/// Absent unless the text is `count` plain numbers of reasonable size.
std::optional<std::vector<double>> Numbers(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string_view word : Words(text)) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    if (!(std::abs(value) <= kLargestNumber)) return std::nullopt;
    numbers.push_back(value);
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

/// What is wrong with an attribute's value, if anything.
std::optional<std::string> Trouble(const std::string& value, Kind kind) {
  const auto number_trouble = [&](std::size_t count, bool positive) -> std::optional<std::string> {
    const auto numbers = Numbers(value, count);
    if (!numbers) {
      return fmt::format(
          "\"{:.40}\" is not {}", value,
          count == 1 ? "a number between -1e6 and 1e6" : "three numbers with blanks between them");
    }
    if (positive &&
        std::any_of(numbers->begin(), numbers->end(), [](double x) { return x <= 0; })) {
      return fmt::format("{:.40} must be above 0", value);
    }
    return std::nullopt;
  };
  switch (kind) {
    case Kind::kWord:
      return value.empty() ? std::optional<std::string>("a name is wanted here") : std::nullopt;
    case Kind::kNumber:
      return number_trouble(1, false);
    case Kind::kPositive:
      return number_trouble(1, true);
    case Kind::kVector:
      return number_trouble(3, false);
    case Kind::kPositiveVector:
      return number_trouble(3, true);
    case Kind::kDirection: {
      if (auto trouble = number_trouble(3, false)) return trouble;
      const double length = Eigen::Vector3d(Numbers(value, 3)->data()).norm();
      if (std::abs(length - 1.0) > kUnitTolerance) return "an axis must have length 1";
      return std::nullopt;
    }
    case Kind::kJointType:
      if (value == "fixed" || value == "continuous" || value == "prismatic") return std::nullopt;
      return fmt::format("unknown joint type \"{:.40}\"; known: fixed, continuous, prismatic",
                         value);
  }
  return std::nullopt;
}

void CheckAttributes(const TiXmlElement& element, const ElementRule& rule, const std::string& field,
                     const std::filesystem::path& file) {
  for (const TiXmlAttribute* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    const auto known =
        std::find_if(rule.attributes.begin(), rule.attributes.end(),
                     [&](const AttributeRule& r) { return r.name == a->NameTStr(); });
    const std::string name = field + "." + a->Name();
    if (known == rule.attributes.end()) {
      throw ErrorAt(file, element, name,
                    "unknown attribute; known here: " + Names(rule.attributes));
    }
    if (const auto trouble = Trouble(a->ValueStr(), known->kind)) {
      throw ErrorAt(file, element, name, *trouble);
    }
  }
  for (const AttributeRule& wanted : rule.attributes) {
    if (wanted.required && element.Attribute(std::string(wanted.name)) == nullptr) {
      throw ErrorAt(file, element, field,
                    fmt::format("the attribute \"{}\" is missing", wanted.name));
    }
  }
}

/// Names, numbers and counts of everything below an element, against the rules.
void CheckElement(const TiXmlElement& element, const ElementRule& rule, const std::string& parent,
                  const std::filesystem::path& file) {
  const std::string* name = element.Attribute(std::string("name"));
  const std::string field = (parent.empty() ? "" : parent + ".") + element.ValueStr() +
                            (name != nullptr ? fmt::format("[{:.60}]", *name) : "");
  CheckAttributes(element, rule, field, file);
  std::vector<int> counts(rule.children.size());
  for (const TiXmlNode* node = element.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (node->ToComment() != nullptr) continue;
    const TiXmlElement* child = node->ToElement();
    if (child == nullptr) throw ErrorAt(file, *node, field, "only elements may stand here");
    const auto known =
        std::find_if(rule.children.begin(), rule.children.end(),
                     [&](const ChildRule& r) { return r.name == child->ValueStr(); });
    if (known == rule.children.end()) {
      throw ErrorAt(file, *child, fmt::format("{}.{:.60}", field, child->ValueStr()),
                    "unknown element; known here: " + Names(rule.children));
    }
    if (++counts[known - rule.children.begin()] > 1 && known->count != Count::kMany) {
      throw ErrorAt(file, *child, field, fmt::format("more than one \"{}\"", known->name));
    }
    CheckElement(*child, RuleNamed(known->name), field, file);
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (rule.children[i].count == Count::kOne && counts[i] == 0) {
      throw ErrorAt(file, element, field,
                    fmt::format("the element \"{}\" is missing", rule.children[i].name));
    }
  }
  if (rule.name == "geometry" && std::count(counts.begin(), counts.end(), 1) != 1) {
    throw ErrorAt(file, element, field, "exactly one of box, cylinder, sphere is wanted here");
  }
}

/// Where well-formed UTF-8 (Unicode, table 3-7, of which overlong forms and surrogates are left to
/// TinyXML, which looks at lengths alone) ends, or the text does.
std::size_t EndOfUtf8(std::string_view text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const auto lead = static_cast<unsigned char>(text[at]);
    const std::size_t length = lead < 0x80                   ? 1
                               : lead >= 0xC2 && lead < 0xE0 ? 2
                               : lead >= 0xE0 && lead < 0xF0 ? 3
                               : lead >= 0xF0 && lead < 0xF5 ? 4
                                                             : 0;
    if (length == 0 || at + length > text.size()) return at;
    for (const char next : text.substr(at + 1, length - 1)) {
      if ((static_cast<unsigned char>(next) & 0xC0) != 0x80) return at;
    }
    at += length;
  }
  return at;
}

/// A pass over the bare text, so that nothing hostile reaches TinyXML, which recurses once per
/// nesting and believes the lead byte of a character, even beyond the end of the text.
void CheckText(const SourceText& source) {
  const std::string_view text = source.text;
  const auto error = [&](std::size_t at, const std::string& problem) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
    return InputError(source.file, static_cast<int>(line), "", problem);
  };
  if (text.size() > kLargestUrdf) throw InputError(source.file, {}, "", "larger than 4 MiB");
  const auto control = std::find_if(text.begin(), text.end(), [](unsigned char c) {
    return c < 0x20 && c != '\n' && c != '\r' && c != '\t';
  });
  if (control != text.end()) {
    throw error(control - text.begin(), "holds a control character, so it is no XML text");
  }
  if (const std::size_t end = EndOfUtf8(text); end < text.size()) {
    throw error(end, "is not UTF-8 here");
  }
  int depth = 0;
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    const bool comment = rest.starts_with("<!--");
    if (!comment && rest.starts_with("<!")) throw error(at, "DOCTYPE and CDATA are not accepted");
    if (comment || rest.starts_with("<?")) {
      const std::size_t end = text.find(comment ? "-->" : "?>", at);
      if (end == std::string_view::npos) throw error(at, "a comment or declaration has no end");
      at = end;
      continue;
    }
    const std::size_t end = text.find_first_of("<>", at + 1);
    if (end == std::string_view::npos || text[end] == '<') throw error(at, "a tag has no end");
    const bool closing = rest.starts_with("</");
    const bool empty = !closing && text[end - 1] == '/';
    depth += closing ? -1 : empty ? 0 : 1;
    if (depth > kDeepestNesting) {
      throw error(at, fmt::format("nested deeper than {} levels", kDeepestNesting));
    }
    at = end;
  }
}

/// What a joint's own type asks for.
void CheckJoint(const TiXmlElement& joint, const std::filesystem::path& file) {
  const std::string field = fmt::format("joint[{:.60}]", joint.Attribute("name"));
  const bool fixed = joint.Attribute("type") == std::string_view("fixed");
  if (fixed == (joint.FirstChildElement("axis") != nullptr)) {
    throw ErrorAt(file, joint, field,
                  fixed ? "a fixed joint has no axis" : "a moving joint needs its axis");
  }
  const TiXmlElement* limit = joint.FirstChildElement("limit");
  if ((joint.Attribute("type") == std::string_view("prismatic")) != (limit != nullptr)) {
    throw ErrorAt(file, joint, field, "a prismatic joint needs its limit, and only that");
  }
  if (limit != nullptr && Numbers(limit->Attribute("lower"), 1)->front() >=
                              Numbers(limit->Attribute("upper"), 1)->front()) {
    throw ErrorAt(file, *limit, field, "lower must be below upper");
  }
}

/// Every link but one hangs on one joint, and all hang on that one in the end.
void CheckTree(const TiXmlElement& robot, const std::filesystem::path& file) {
  std::map<std::string, std::string> parents;  // by link; of the root: empty
  for (auto* link = robot.FirstChildElement("link"); link != nullptr;
       link = link->NextSiblingElement("link")) {
    if (!parents.emplace(link->Attribute("name"), "").second) {
      throw ErrorAt(file, *link, fmt::format("link[{:.60}]", link->Attribute("name")),
                    "a second link of this name");
    }
  }
  if (parents.empty() || parents.size() > kMostLinks) {
    throw ErrorAt(file, robot, "robot", fmt::format("1 to {} links are accepted", kMostLinks));
  }
  std::set<std::string> joints;
  for (auto* joint = robot.FirstChildElement("joint"); joint != nullptr;
       joint = joint->NextSiblingElement("joint")) {
    const auto error = [&](const std::string& problem) {
      return ErrorAt(file, *joint, fmt::format("joint[{:.60}]", joint->Attribute("name")), problem);
    };
    if (!joints.insert(joint->Attribute("name")).second) throw error("a second joint of this name");
    CheckJoint(*joint, file);
    const std::string parent = joint->FirstChildElement("parent")->Attribute("link");
    const std::string child = joint->FirstChildElement("child")->Attribute("link");
    for (const std::string& end : {parent, child}) {
      if (!parents.contains(end)) throw error(fmt::format("there is no link \"{:.60}\"", end));
    }
    if (!parents[child].empty()) {
      throw error(fmt::format("the link \"{:.60}\" hangs on two joints", child));
    }
    parents[child] = parent;
  }
  if (joints.size() + 1 != parents.size()) {
    throw ErrorAt(
        file, robot, "robot",
        fmt::format("{} links on {} joints are not one tree", parents.size(), joints.size()));
  }
  for (const auto& [link, parent] : parents) {
    std::string above = parent;
    for (std::size_t steps = 0; !above.empty(); above = parents[above]) {
      if (++steps > parents.size()) {
        throw ErrorAt(file, robot, "robot",
                      fmt::format("the link \"{:.60}\" hangs on a ring", link));
      }
    }
  }
}

void CheckXml(const SourceText& urdf) {
  CheckText(urdf);
  TiXmlDocument document;
  document.Parse(urdf.text.c_str(), nullptr, TIXML_ENCODING_UTF8);
  if (document.Error()) {
    const int row = document.ErrorRow();
    throw InputError(urdf.file, row > 0 ? std::optional<int>(row) : std::nullopt, "",
                     fmt::format("not valid XML: {}", document.ErrorDesc()));
  }
  const TiXmlElement* robot = document.RootElement();
  if (robot == nullptr || robot->ValueStr() != "robot" || robot->NextSiblingElement() != nullptr) {
    throw InputError(urdf.file, 1, "robot", "a URDF is one element \"robot\"");
  }
  CheckElement(*robot, RuleNamed("robot"), "", urdf.file);
  CheckTree(*robot, urdf.file);
}

Eigen::Vector3d ToEigen(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Eigen::Isometry3d ToEigen(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  X.translation() = ToEigen(pose.position);
  return X;
}

Shape ToShape(const urdf::Pose& origin, const urdf::Geometry& geometry) {
  Shape shape{ToEigen(origin), {}};
  if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
    shape.geometry = Box{ToEigen(box->dim)};
  } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
    shape.geometry = Cylinder{cylinder->radius, cylinder->length};
  } else {
    shape.geometry = Sphere{dynamic_cast<const urdf::Sphere&>(geometry).radius};
  }
  return shape;
}

/// A real body's moments about its principal axes are positive and none exceeds the sum of the
/// other two.
Inertial ToInertial(const urdf::Inertial& from, const std::string& link,
                    const std::filesystem::path& file) {
  const Eigen::Isometry3d X_LCm = ToEigen(from.origin);
  Eigen::Matrix3d I;
  I << from.ixx, from.ixy, from.ixz, from.ixy, from.iyy, from.iyz, from.ixz, from.iyz, from.izz;
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I).eigenvalues();
  const std::string field = fmt::format("link[{:.60}].inertial.inertia", link);
  if (!(moments(0) > 0.0))
    throw InputError(file, {}, field, "the matrix must be positive definite");
  if (moments(2) > (moments(0) + moments(1)) * (1.0 + 1e-3)) {
    throw InputError(file, {}, field,
                     "no body has such moments: the largest exceeds the sum of the other two");
  }
  return {from.mass, X_LCm.translation(), X_LCm.linear() * I * X_LCm.linear().transpose()};
}

Link ToLink(const urdf::Link& from, const std::filesystem::path& file) {
  Link link;
  link.name = from.name;
  if (from.inertial) link.inertial = ToInertial(*from.inertial, from.name, file);
  for (const auto& c : from.collision_array) {
    link.collisions.push_back(ToShape(c->origin, *c->geometry));
  }
  for (const auto& v : from.visual_array) link.visuals.push_back(ToShape(v->origin, *v->geometry));
  return link;
}

Joint ToJoint(const urdf::Joint& from) {
  Joint joint;
  joint.name = from.name;
  joint.type = from.type == urdf::Joint::FIXED        ? JointType::kFixed
               : from.type == urdf::Joint::CONTINUOUS ? JointType::kContinuous
                                                      : JointType::kPrismatic;
  joint.parent = from.parent_link_name;
  joint.child = from.child_link_name;
  joint.X_PJ = ToEigen(from.parent_to_joint_origin_transform);
  if (joint.type != JointType::kFixed) joint.axis_J = ToEigen(from.axis).normalized();
  if (joint.type == JointType::kPrismatic) {
    joint.lower = from.limits->lower;
    joint.upper = from.limits->upper;
  }
  return joint;
}

}  // namespace

UrdfBody ParseUrdf(const SourceText& urdf) {
  CheckXml(urdf);
  console_bridge::noOutputHandler();  // what it would print is no complaint a person could use
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(urdf.text);
  if (model == nullptr || model->getRoot() == nullptr) {
    throw InputError(urdf.file, {}, "robot", "urdfdom does not accept this as a robot");
  }
  UrdfBody body;
  body.name = model->getName();
  std::vector<urdf::LinkConstSharedPtr> open{model->getRoot()};
  while (!open.empty()) {
    const urdf::LinkConstSharedPtr link = open.back();
    open.pop_back();
    if (link->parent_joint != nullptr) body.joints.push_back(ToJoint(*link->parent_joint));
    body.links.push_back(ToLink(*link, urdf.file));
    open.insert(open.end(), link->child_links.rbegin(), link->child_links.rend());
  }
  return body;
}

}  // namespace kantaro::robot
