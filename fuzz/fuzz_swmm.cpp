#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/input_error.hpp"
#include "network/formats.hpp"

// Any bytes give a network or an InputError, and a network that was read can be written as YAML,
// reads back from there, and is the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kantaro::network::Network network;
  try {
    network = kantaro::network::ParseSwmm(std::string(data, data + size), "fuzz.inp");
  } catch (const kantaro::InputError&) {
    return 0;
  }
  (void)kantaro::network::Describe(network);
  (void)kantaro::network::DescribeJson(network);
  if (!(kantaro::network::ParseYaml(kantaro::network::ToYaml(network), "again.yaml") == network)) {
    std::abort();
  }
  return 0;
}
