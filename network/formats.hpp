#pragma once

#include <filesystem>
#include <string>

#include "network/network.hpp"

namespace kantaro::network {

/// Reads a network by its file's ending: .yaml or .yml is the project's own format, .inp EPA
/// SWMM 5. What is returned has passed Check(). @throws InputError
[[nodiscard]] Network ReadNetwork(const std::filesystem::path& file);

/// The project's format (docs/network_format.md). @throws InputError naming line and field.
[[nodiscard]] Network ParseYaml(const std::string& text, const std::filesystem::path& name);
[[nodiscard]] std::string ToYaml(const Network& network);

/// EPA SWMM 5.x input. Circular conduits with coordinates become pipes, the rest is listed in
/// `skipped`; what the file lacks is filled from stated defaults, each named in `remarks`.
/// @throws InputError if there is no network to be had from it.
[[nodiscard]] Network ParseSwmm(const std::string& text, const std::filesystem::path& name);

/// Geometry and references. @throws InputError (file `name`, no line) for the first fault found.
void Check(const Network& network, const std::filesystem::path& name);

/// What `kantaro network` prints: counts, lengths, diameters, what KANTARO can enter, what was
/// skipped and why.
[[nodiscard]] std::string Describe(const Network& network);
[[nodiscard]] std::string DescribeJson(const Network& network);

}  // namespace kantaro::network
