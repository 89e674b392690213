#include "robot/recording/png.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <queue>
#include <stdexcept>
#include <utility>

namespace kantaro::robot {
namespace {

constexpr int kSymbols = 257;  ///< of RFC 1951: the bytes, and the end of a block
constexpr int kEndOfBlock = 256;
constexpr int kLongestCode = 15;
constexpr int kRowsOfBlock = 32;  ///< few enough to follow the picture, many enough for 129 bytes

using Counts = std::array<std::uint32_t, kSymbols>;
using Lengths = std::array<std::uint8_t, kSymbols>;

/// How deep each symbol that occurs hangs in Huffman's tree.
Lengths DepthsOf(const Counts& counts) {
  struct Node {
    int parent{-1}, depth{};
  };
  std::vector<Node> nodes(kSymbols);
  using Weight = std::pair<std::uint64_t, int>;  // and the node
  std::priority_queue<Weight, std::vector<Weight>, std::greater<>> roots;
  for (int symbol = 0; symbol < kSymbols; ++symbol) {
    if (counts[symbol] > 0) roots.emplace(counts[symbol], symbol);
  }
  while (roots.size() > 1) {
    const int joined = static_cast<int>(nodes.size());
    std::uint64_t weight = 0;
    for (int child = 0; child < 2; ++child) {
      weight += roots.top().first;
      nodes[roots.top().second].parent = joined;
      roots.pop();
    }
    nodes.push_back({});
    roots.emplace(weight, joined);
  }
  // A node stands before its parent.
  for (auto node = static_cast<int>(nodes.size()) - 2; node >= 0; --node) {
    if (nodes[node].parent >= 0) nodes[node].depth = nodes[nodes[node].parent].depth + 1;
  }
  Lengths lengths{};
  for (int symbol = 0; symbol < kSymbols; ++symbol)
    lengths[symbol] = static_cast<std::uint8_t>(std::min(nodes[symbol].depth, 255));
  return lengths;
}

/// Lengths that deflate can tell: counts are evened out until the tree is shallow enough.
Lengths CodeLengths(Counts counts) {
  for (;;) {
    const Lengths lengths = DepthsOf(counts);
    if (*std::max_element(lengths.begin(), lengths.end()) <= kLongestCode) return lengths;
    for (std::uint32_t& count : counts) count = (count + 1) / 2;
  }
}

struct Code {
  std::uint32_t bits{}, length{};
};

/// RFC 1951, 3.2.2. Codes stand in the stream with their first bit lowest.
std::array<Code, kSymbols> CodesOf(const Lengths& lengths) {
  std::array<std::uint32_t, kLongestCode + 2> next{};
  for (const std::uint8_t length : lengths) {
    if (length > 0) ++next[length + 1];
  }
  for (int length = 1; length <= kLongestCode + 1; ++length)
    next[length] = (next[length] + next[length - 1]) << 1;
  std::array<Code, kSymbols> codes{};
  for (int symbol = 0; symbol < kSymbols; ++symbol) {
    codes[symbol].length = lengths[symbol];
    std::uint32_t code = lengths[symbol] > 0 ? next[lengths[symbol]]++ : 0;
    for (int bit = 0; bit < lengths[symbol]; ++bit, code >>= 1)
      codes[symbol].bits = codes[symbol].bits << 1 | (code & 1);
  }
  return codes;
}

class BitWriter {
 public:
  explicit BitWriter(std::vector<std::uint8_t>& out) : out_(out) {}

  void Put(std::uint32_t bits, std::uint32_t count) {
    held_ |= static_cast<std::uint64_t>(bits) << count_;
    count_ += count;
    for (; count_ >= 8; count_ -= 8, held_ >>= 8) out_.push_back(static_cast<std::uint8_t>(held_));
  }

  void PutAll(const std::uint8_t* bytes, std::size_t size,
              const std::array<Code, kSymbols>& codes) {
    std::size_t at = out_.size();
    out_.resize(at + size * 2 + 8);  // no code is longer than 15 bits
    std::uint64_t held = held_;
    std::uint32_t count = count_;
    for (std::size_t i = 0; i < size;) {
      // Three codes fit beside the seven bits that may be left.
      for (const std::size_t end = std::min(i + 3, size); i < end; ++i) {
        const Code& code = codes[bytes[i]];
        held |= static_cast<std::uint64_t>(code.bits) << count;
        count += code.length;
      }
      std::memcpy(out_.data() + at, &held, sizeof held);  // little endian, as all of x86
      at += count / 8;
      held >>= count & ~7U;
      count &= 7U;
    }
    out_.resize(at);
    held_ = held;
    count_ = count;
  }

  void FillByte() {
    if (count_ > 0) Put(0, 8 - count_);
  }

 private:
  std::vector<std::uint8_t>& out_;
  std::uint64_t held_{};
  std::uint32_t count_{};
};

Counts CountsOf(const std::uint8_t* bytes, std::size_t size) {
  std::array<std::array<std::uint32_t, 256>, 4>
      parts{};  // equal bytes in a row wait for each other
  for (std::size_t i = 0; i < size; ++i) ++parts[i % 4][bytes[i]];
  Counts counts{};
  for (int symbol = 0; symbol < 256; ++symbol) {
    for (const auto& part : parts) counts[symbol] += part[symbol];
  }
  counts[kEndOfBlock] = 1;
  return counts;
}

/// One block of RFC 1951, 3.2.7, of literals only.
void PutBlock(const std::uint8_t* bytes, std::size_t size, bool last, BitWriter& out) {
  const Lengths lengths = CodeLengths(CountsOf(bytes, size));
  const auto codes = CodesOf(lengths);
  out.Put(last ? 1 : 0, 1);
  out.Put(2, 2);  // codes of its own
  out.Put(0, 5);  // 257 of them
  out.Put(0, 5);  // and one for distances, which is not there
  out.Put(15,
          4);  // the lengths of 19 codes for lengths: 16 to 18 unused, 0 to 15 in four bits each
  for (int i = 0; i < 19; ++i) out.Put(i < 3 ? 0 : 4, 3);
  const auto put_length = [&](std::uint32_t length) {
    std::uint32_t turned = 0;
    for (int bit = 0; bit < 4; ++bit) turned = turned << 1 | (length >> bit & 1);
    out.Put(turned, 4);
  };
  for (const std::uint8_t length : lengths) put_length(length);
  put_length(0);
  out.PutAll(bytes, size, codes);
  out.Put(codes[kEndOfBlock].bits, codes[kEndOfBlock].length);
}

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
  PutBig(static_cast<std::uint32_t>(crc32(0, out.data() + begin + 4, static_cast<uInt>(size))),
         out);
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
  out.reserve(2 * rows.size() + 4096);
  std::size_t chunk = OpenChunk("IHDR", out);
  PutBig(static_cast<std::uint32_t>(image.cols), out);
  PutBig(static_cast<std::uint32_t>(image.rows), out);
  for (const int byte : {8, 2, 0, 0, 0}) out.push_back(static_cast<std::uint8_t>(byte));
  CloseChunk(chunk, out);

  chunk = OpenChunk("IDAT", out);
  out.insert(out.end(), {0x78, 0x01});  // zlib's header (RFC 1950)
  BitWriter bits(out);
  const std::size_t block = kRowsOfBlock * (rows.size() / image.rows);
  for (std::size_t at = 0; at < rows.size(); at += block) {
    const std::size_t size = std::min(block, rows.size() - at);
    PutBlock(rows.data() + at, size, at + size == rows.size(), bits);
  }
  bits.FillByte();
  PutBig(static_cast<std::uint32_t>(adler32(1, rows.data(), static_cast<uInt>(rows.size()))), out);
  CloseChunk(chunk, out);
  CloseChunk(OpenChunk("IEND", out), out);
  return out;
}

}  // namespace kantaro::robot
