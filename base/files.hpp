#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace kantaro {

/// Largest input file the program reads: 256 MiB, some ten times a city's SWMM file.
inline constexpr std::size_t kLargestInput = std::size_t{256} << 20;

/// The whole file as bytes. @throws InputError if it is missing, a folder, unreadable or above
/// `limit` bytes.
[[nodiscard]] std::string ReadInputFile(const std::filesystem::path& file,
                                        std::size_t limit = kLargestInput);

/// Writes beside the file and renames, so that a reader sees the old content or the new, never
/// half. Makes the parent folders. @throws InputError if the place cannot be written.
void WriteFileAtomically(const std::filesystem::path& file, std::string_view content);

}  // namespace kantaro
