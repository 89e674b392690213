#pragma once

#include <string>

#include "base/yaml.hpp"
#include "network/network.hpp"

// The part of the YAML format that holds what is in the map but not built, and what a reader of
// another format left out or filled in.
namespace kantaro::network {

/// The keys `not_enterable` and `remarks` of a network, if they are there. @throws InputError
void ReadNotes(const YamlNode& root, Network& network);

/// The same as text to stand at the end of the file, empty if there is nothing to say.
[[nodiscard]] std::string NotesText(const Network& network);

}  // namespace kantaro::network
