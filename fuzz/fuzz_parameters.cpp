#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include <unistd.h>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "navigation/parameters.hpp"
#include "perception/parameters.hpp"

namespace {

/// The readers take files: one for each process that fuzzes.
const std::filesystem::path& InputFile() {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("fuzz_parameters_" + std::to_string(getpid()));
  return file;
}

template <typename Read>
void Tolerate(Read read) {
  try {
    (void)read(InputFile());
  } catch (const kantaro::InputError&) {
  }
}

}  // namespace

// Any bytes are the parameters of a room, or an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kantaro::WriteFileAtomically(InputFile(), {reinterpret_cast<const char*>(data), size});
  Tolerate(kantaro::navigation::ReadParameters);
  Tolerate(kantaro::perception::ReadParameters);
  Tolerate(kantaro::perception::ReadLandmarkCalibration);
  std::filesystem::remove(InputFile());
  return 0;
}
