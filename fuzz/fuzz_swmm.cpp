#include <cstddef>
#include <cstdint>
#include <string>

#include "base/input_error.hpp"
#include "network/formats.hpp"

// Any bytes give a network or an InputError, and a network that was read can be written as YAML and
// read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kantaro::network::Network network;
  try {
    network = kantaro::network::ParseSwmm(std::string(data, data + size), "fuzz.inp");
  } catch (const kantaro::InputError&) {
    return 0;
  }
  (void)kantaro::network::Describe(network);
  (void)kantaro::network::DescribeJson(network);
  (void)kantaro::network::ParseYaml(kantaro::network::ToYaml(network), "again.yaml");
  return 0;
}
