// Any bytes are either a YAML tree that can be walked to its leaves, or an InputError.
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/yaml.hpp"

namespace {

void ReadAsEveryType(const kantaro::YamlNode& node) {
  const auto tolerate = [](auto&& read) {
    try {
      (void)read();
    } catch (const kantaro::InputError&) {
    }
  };
  tolerate([&] { return node.Text(); });
  tolerate([&] { return node.Boolean(); });
  tolerate([&] { return node.Positive(); });
  tolerate([&] { return node.Integer(-5, 5); });
  tolerate([&] { return node.Numbers(3); });
}

void Walk(const kantaro::YamlNode& node) {
  if (node.IsMap()) {
    for (const auto& [key, value] : node.Entries()) Walk(value);
  } else if (node.IsSequence()) {
    for (const kantaro::YamlNode& element : node.Elements()) Walk(element);
  } else {
    ReadAsEveryType(node);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    Walk(kantaro::YamlNode::Parse(std::string(data, data + size), "fuzz.yaml"));
  } catch (const kantaro::InputError&) {
  }
  return 0;
}
