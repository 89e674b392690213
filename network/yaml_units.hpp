#pragma once

#include <string>

#include "base/yaml.hpp"

// Lengths and angles as the YAML format holds them: millimetres and degrees. Every value that is
// written reads back as the same double, so the product is formed in more than double precision:
// 0.0021 m is the quotient of no double by 1000.
namespace kantaro::network {

/// The number in the node, in metres. @throws InputError if it is no number
[[nodiscard]] double Millimetres(const YamlNode& node);
/// The number in the node, in radians. @throws InputError if it is no number
[[nodiscard]] double Degrees(const YamlNode& node);

/// The shortest number that `Millimetres` reads as `value_m`.
[[nodiscard]] std::string MillimetreText(double value_m);
/// The shortest number that `Degrees` reads as `value_rad`.
[[nodiscard]] std::string DegreeText(double value_rad);

}  // namespace kantaro::network
