#include "network/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/files.hpp"
#include "base/input_error.hpp"

namespace kantaro::network {
namespace {

constexpr std::size_t kLargestYaml = std::size_t{128} << 20;  // as YamlNode::Load

}  // namespace

Network ReadNetwork(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".yaml" || ending == ".yml")
    return ParseYaml(ReadInputFile(file, kLargestYaml), file);
  if (ending == ".inp") return ParseSwmm(ReadInputFile(file), file);
  throw InputError(file, std::nullopt, "",
                   "a network is read from a file ending in .yaml, .yml or .inp (EPA SWMM)");
}

}  // namespace kantaro::network
