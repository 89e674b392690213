#include "network/yaml_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>

namespace kantaro::network {
namespace {

constexpr long double kMillimetres = 1000.0L;                               // in a metre
constexpr long double kDegrees = 180.0L / std::numbers::pi_v<long double>;  // in a radian

/// The number in the text over the units in one of ours.
double InUnits(std::string_view text, long double units) {
  if (text.starts_with('+')) text.remove_prefix(1);
  long double value{};
  std::from_chars(text.data(), text.data() + text.size(), value);
  return static_cast<double>(value / units);
}

double Scaled(const YamlNode& node, long double units) {
  (void)node.Number();  // which complains of what is no number
  return InUnits(node.Text(), units);
}

std::string ScaledText(double value, long double units) {
  const long double scaled = value * units;
  // Not below the digits before the point: 250, not 2.5e+02.
  const int whole =
      std::abs(scaled) < 10.0L ? 1 : static_cast<int>(std::log10(std::abs(scaled))) + 1;
  std::string text;
  for (int digits = std::min(whole, 17); digits <= std::numeric_limits<long double>::max_digits10;
       ++digits) {
    text = fmt::format("{:.{}g}", scaled, digits);
    if (InUnits(text, units) == value) break;
  }
  return text;
}

}  // namespace

double Millimetres(const YamlNode& node) { return Scaled(node, kMillimetres); }
double Degrees(const YamlNode& node) { return Scaled(node, kDegrees); }
std::string MillimetreText(double value_m) { return ScaledText(value_m, kMillimetres); }
std::string DegreeText(double value_rad) { return ScaledText(value_rad, kDegrees); }

}  // namespace kantaro::network
