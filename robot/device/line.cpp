#include "robot/device/line.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace kantaro::robot {
namespace {

constexpr std::size_t kMostUnsent = 200'000;  // a second at 2 Mbps

const std::map<int, speed_t>& Speeds() {
  static const std::map<int, speed_t> speeds{{115200, B115200},   {230400, B230400},
                                             {460800, B460800},   {921600, B921600},
                                             {1000000, B1000000}, {2000000, B2000000}};
  return speeds;
}

std::system_error Failure(const std::string& what) {
  return {errno, std::generic_category(), what};
}

void MakeRaw(int descriptor, speed_t speed) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) throw Failure("this is no serial line");
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~(CSTOPB | CRTSCTS);
  cfsetispeed(&settings, speed);
  cfsetospeed(&settings, speed);
  if (tcsetattr(descriptor, TCSANOW, &settings) != 0) throw Failure("the line cannot be set up");
}

}  // namespace

ByteLine::ByteLine(ByteLine&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      gone_(other.gone_),
      unsent_(std::move(other.unsent_)) {}

ByteLine& ByteLine::operator=(ByteLine&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(gone_, other.gone_);
  std::swap(unsent_, other.unsent_);
  return *this;
}

ByteLine::~ByteLine() { Close(); }

void ByteLine::Close() {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
  gone_ = true;
}

wire::Bytes ByteLine::Read() {
  wire::Bytes bytes;
  std::array<wire::Byte, 4096> block{};
  while (descriptor_ >= 0) {
    const ssize_t got = read(descriptor_, block.data(), block.size());
    if (got > 0) {
      gone_ = false;
      bytes.insert(bytes.end(), block.begin(), block.begin() + got);
      continue;
    }
    if (got < 0 && errno == EINTR) continue;
    gone_ = got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK);
    break;
  }
  return bytes;
}

void ByteLine::Write(std::span<const wire::Byte> bytes) {
  unsent_.insert(unsent_.end(), bytes.begin(), bytes.end());
  std::size_t sent = 0;
  while (descriptor_ >= 0 && sent < unsent_.size()) {
    const ssize_t took = write(descriptor_, unsent_.data() + sent, unsent_.size() - sent);
    if (took < 0 && errno == EINTR) continue;
    if (took < 0) break;  // full, or gone: reading tells
    sent += static_cast<std::size_t>(took);
  }
  if (unsent_.size() - sent > kMostUnsent) sent = unsent_.size() - kMostUnsent;
  unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<long>(sent));
}

bool IsSerialSpeed(int bits_per_s) { return Speeds().contains(bits_per_s); }

ByteLine OpenSerialLine(const std::filesystem::path& device, int bits_per_s) {
  if (!IsSerialSpeed(bits_per_s)) throw std::invalid_argument("no speed of a serial line");
  const int descriptor = open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) throw Failure("it cannot be opened");
  ByteLine line(descriptor);
  MakeRaw(descriptor, Speeds().at(bits_per_s));
  // Two hosts on one line would both lose.
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) throw Failure("another program uses it");
  tcflush(descriptor, TCIOFLUSH);
  return line;
}

PlayedLine OpenPlayedLine() {
  const int descriptor = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw Failure("no pseudo-terminal can be had");
  PlayedLine played{ByteLine(descriptor), {}};
  std::array<char, 128> name{};
  if (grantpt(descriptor) != 0 || unlockpt(descriptor) != 0 ||
      ptsname_r(descriptor, name.data(), name.size()) != 0) {
    throw Failure("the pseudo-terminal cannot be used");
  }
  MakeRaw(descriptor, B2000000);
  played.device = name.data();
  return played;
}

}  // namespace kantaro::robot
