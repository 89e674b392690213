#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "network/formats.hpp"
#include "network/generator.hpp"

// Whatever is asked for within the bounds, the network is sound, as large as asked for, the same
// again, and survives being written and read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace network = kantaro::network;
  std::uint8_t bytes[13] = {};
  std::memcpy(bytes, data, size < sizeof(bytes) ? size : sizeof(bytes));
  network::GeneratorOptions options;
  options.layout = static_cast<network::Layout>(bytes[0] % 3);
  options.pipes = 1 + (bytes[1] + 256 * bytes[2]) % 120;
  options.spacing_m = network::kShortestManholeSpacing_m + bytes[3] + bytes[4] / 256.0;
  std::memcpy(&options.seed, bytes + 5, sizeof(options.seed));

  const network::Network made = network::Generate(options);
  network::Check(made, "made");
  const std::string text = network::ToYaml(made);
  if (made.pipes.size() != *options.pipes || network::ToYaml(network::Generate(options)) != text ||
      network::ToYaml(network::ParseYaml(text, "made.yaml")) != text) {
    std::abort();
  }
  return 0;
}
