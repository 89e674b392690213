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

/// Keeps other processes from an output while it is written: an empty file beside it, locked. The
/// kernel frees the lock of a process that dies; the file it leaves hinders nobody.
class FileLock {
 public:
  /// Makes the parent folders.
  /// @param wanted   what is locked, for the message
  /// @throws InputError if another holds the lock, or the file cannot be made.
  FileLock(std::filesystem::path file, const std::filesystem::path& wanted);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  std::filesystem::path file_;
  int descriptor_{-1};
};

}  // namespace kantaro
