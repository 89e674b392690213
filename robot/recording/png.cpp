#include "robot/recording/png.hpp"

#include <libdeflate.h>

#include <cstddef>
#include <memory>
#include <new>
#include <stdexcept>

namespace kantaro::robot {
namespace {

constexpr int kLevel =
    1;  ///< the fastest that compresses: noise leaves little for the others to find

/// Rows as PNG filters them with "Average": the filter's number, then red, green and blue of each
/// pixel less the mean of the left and the upper one's. Of two neighbours noise adds less than of
/// one.
std::vector<std::uint8_t> Filtered(const cv::Mat& image) {
  const std::size_t width = 3 * static_cast<std::size_t>(image.cols);
  std::vector<std::uint8_t> rows((width + 1) * image.rows);
  const std::vector<std::uint8_t> nothing(width, 0);
  for (int y = 0; y < image.rows; ++y) {
    std::uint8_t* const out = rows.data() + y * (width + 1) + 1;
    const std::uint8_t* const in = image.ptr(y);
    const std::uint8_t* const above = y > 0 ? image.ptr(y - 1) : nothing.data();
    out[-1] = 3;
    for (int c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(in[2 - c] - above[2 - c] / 2);
    for (std::size_t x = 3; x < width; x += 3) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at = x + 2 - c;
        out[x + c] = static_cast<std::uint8_t>(in[at] - (in[at - 3] + above[at]) / 2);
      }
    }
  }
  return rows;
}

void PutBig(std::uint32_t number, std::vector<std::uint8_t>& out) {
  for (int shift = 24; shift >= 0; shift -= 8)
    out.push_back(static_cast<std::uint8_t>(number >> shift));
}

/// Turns what stands from `begin` on, a chunk's type and data behind four bytes for its length,
/// into a chunk.
void CloseChunk(std::size_t begin, std::vector<std::uint8_t>& out) {
  const std::size_t size = out.size() - begin - 4;
  for (int i = 0; i < 4; ++i)
    out[begin + i] = static_cast<std::uint8_t>((size - 4) >> (24 - 8 * i));
  PutBig(libdeflate_crc32(0, out.data() + begin + 4, size), out);
}

std::size_t OpenChunk(const char* type, std::vector<std::uint8_t>& out) {
  const std::size_t begin = out.size();
  out.resize(begin + 4);
  out.insert(out.end(), type, type + 4);
  return begin;
}

}  // namespace

std::vector<std::uint8_t> EncodePng(const cv::Mat& image) {
  if (image.type() != CV_8UC3 || image.empty())
    throw std::invalid_argument("PNG: the image is not 8-bit BGR");
  const std::vector<std::uint8_t> rows = Filtered(image);
  std::vector<std::uint8_t> out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::size_t chunk = OpenChunk("IHDR", out);
  PutBig(static_cast<std::uint32_t>(image.cols), out);
  PutBig(static_cast<std::uint32_t>(image.rows), out);
  for (const int byte : {8, 2, 0, 0, 0}) out.push_back(static_cast<std::uint8_t>(byte));
  CloseChunk(chunk, out);

  chunk = OpenChunk("IDAT", out);
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kLevel), &libdeflate_free_compressor);
  if (compressor == nullptr) throw std::bad_alloc();
  const std::size_t begin = out.size();
  out.resize(begin + libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  out.resize(begin + libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(),
                                              out.data() + begin, out.size() - begin));
  CloseChunk(chunk, out);
  CloseChunk(OpenChunk("IEND", out), out);
  return out;
}

}  // namespace kantaro::robot
