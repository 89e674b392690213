#include "base/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "base/input_error.hpp"

namespace kantaro {
namespace {

std::string Sentence(const std::filesystem::path& file, std::optional<int> line,
                     const std::string& field, const std::string& problem) {
  std::string text = file.string();
  if (line) text += fmt::format("{}{}", text.empty() ? "line " : ":", *line);
  if (!text.empty()) text += ": ";
  if (!field.empty()) text += field + ": ";
  return text + problem;
}

/// Whether the name still means the file that was opened: who held the lock may have removed it.
bool Names(const std::filesystem::path& file, int descriptor) {
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

InputError::InputError(const std::filesystem::path& file, std::optional<int> line,
                       std::string field, const std::string& problem)
    : std::runtime_error(Sentence(file, line, field, problem)),
      field_(std::move(field)),
      line_(line) {}

std::string ReadInputFile(const std::filesystem::path& file, std::size_t limit) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw InputError(file, {}, "", "no such file");
  if (std::filesystem::is_directory(status)) {
    throw InputError(file, {}, "", "this is a folder, a file is wanted");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file, {}, "", "cannot be read");
  std::string content;
  std::string block(std::size_t{1} << 20, '\0');
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())),
         stream.gcount() > 0) {
    content.append(block, 0, static_cast<std::size_t>(stream.gcount()));
    if (content.size() > limit) {
      throw InputError(file, {}, "",
                       fmt::format("larger than the {} MiB that are read", limit >> 20));
    }
  }
  return content;
}

void WriteFileAtomically(const std::filesystem::path& file, std::string_view content) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  const std::filesystem::path beside = file.string() + fmt::format(".{}.part", getpid());
  {
    std::ofstream stream(beside, std::ios::binary | std::ios::trunc);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.flush();
    if (!stream) {
      std::filesystem::remove(beside, error);
      throw InputError(file, {}, "", "cannot be written");
    }
  }
  std::filesystem::rename(beside, file, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(beside, error);
    throw InputError(file, {}, "", "cannot be written: " + reason);
  }
}

FileLock::FileLock(std::filesystem::path file, const std::filesystem::path& wanted)
    : file_(std::move(file)) {
  std::error_code error;
  if (file_.has_parent_path()) std::filesystem::create_directories(file_.parent_path(), error);
  while (true) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw InputError(wanted, {}, "",
                       "cannot be written: " + std::generic_category().message(errno));
    const bool locked = flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
    if (locked && Names(file_, descriptor_)) return;
    close(descriptor_);
    if (!locked)
      throw InputError(wanted, {}, "",
                       "another process is writing there: wait for its end, or name another place");
  }
}

FileLock::~FileLock() {
  unlink(file_.c_str());
  close(descriptor_);
}

}  // namespace kantaro
