#include "robot/device/matroska.hpp"

#include <chrono>
#include <string_view>

namespace kantaro::robot {
namespace {

using wire::Byte;
using wire::Bytes;

void Append(Bytes& bytes, const Bytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

void AppendBigEndian(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes.push_back(Byte(value >> (8 * i)));
}

/// An element's identity, whose leading byte tells its length, and the size of its body.
Bytes Head(std::uint32_t id, std::uint64_t size) {
  Bytes head;
  AppendBigEndian(head, id, id > 0xFFFFFF ? 4 : id > 0xFFFF ? 3 : id > 0xFF ? 2 : 1);
  AppendBigEndian(head, (std::uint64_t{1} << 56) | size, 8);
  return head;
}
constexpr std::uint64_t kUnknownSize = (std::uint64_t{1} << 56) - 1;

Bytes Element(std::uint32_t id, const Bytes& body) {
  Bytes element = Head(id, body.size());
  Append(element, body);
  return element;
}
Bytes Number(std::uint32_t id, std::uint64_t value) {
  Bytes body;
  AppendBigEndian(body, value, 8);
  return Element(id, body);
}
Bytes Text(std::uint32_t id, std::string_view text) {
  return Element(id, Bytes(text.begin(), text.end()));
}
Bytes Together(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) Append(all, part);
  return all;
}

}  // namespace

Bytes MatroskaHead(int width_px, int height_px, RunTime period) {
  const auto width = static_cast<std::uint64_t>(width_px);
  const auto height = static_cast<std::uint64_t>(height_px);
  const Bytes ebml =
      Element(0x1A45DFA3,
              Together({Number(0x4286, 1), Number(0x42F7, 1), Number(0x42F2, 4), Number(0x42F3, 8),
                        Text(0x4282, "matroska"), Number(0x4287, 4), Number(0x4285, 2)}));
  const Bytes info =
      Element(0x1549A966, Together({Number(0x2AD7B1, 1000),  // stamps count 1000 ns
                                    Text(0x4D80, "kantaro"), Text(0x5741, "kantaro")}));
  const Bytes video = Element(0xE0, Together({Number(0xB0, width), Number(0xBA, height),
                                              Text(0x2EB524, "BGR\x18")}));  // 24 bits
  const Bytes track =
      Element(0xAE, Together({Number(0xD7, 1), Number(0x73C5, 1), Number(0x83, 1), Number(0x9C, 0),
                              Number(0x23E383, static_cast<std::uint64_t>(period.count())),
                              Text(0x86, "V_UNCOMPRESSED"), video}));
  return Together({ebml, Head(0x18538067, kUnknownSize), info, Element(0x1654AE6B, track)});
}

Bytes MatroskaImage(const cv::Mat& image, RunTime stamp) {
  const std::size_t row_bytes = image.elemSize() * static_cast<std::size_t>(image.cols);
  const auto stamp_us = std::chrono::duration_cast<std::chrono::microseconds>(stamp).count();
  const Bytes time = Number(0xE7, static_cast<std::uint64_t>(stamp_us));
  const Bytes block{0x81, 0, 0, 0x80};  // track 1, 0 after the cluster's time, a key frame
  const std::size_t block_size = block.size() + row_bytes * static_cast<std::size_t>(image.rows);
  const Bytes block_head = Head(0xA3, block_size);
  Bytes cluster = Head(0x1F43B675, time.size() + block_head.size() + block_size);
  cluster.reserve(cluster.size() + time.size() + block_head.size() + block_size);
  Append(cluster, time);
  Append(cluster, block_head);
  Append(cluster, block);
  for (int row = 0; row < image.rows; ++row) {
    cluster.insert(cluster.end(), image.ptr(row), image.ptr(row) + row_bytes);
  }
  return cluster;
}

}  // namespace kantaro::robot
