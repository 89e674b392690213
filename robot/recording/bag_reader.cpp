#include "robot/recording/bag_reader.hpp"

#include <cstring>
#include <utility>

#include "base/input_error.hpp"

namespace kantaro::robot {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
/// rosbag fills a chunk to 768 KiB, and ends it after the message that passes that.
constexpr std::uint32_t kLargestBlock = 64U << 20;

enum class Op : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

template <typename Number>
Number Load(std::string_view bytes) {
  Number number{};
  std::memcpy(&number, bytes.data(), sizeof number);  // bags and x86-64 are little-endian
  return number;
}

}  // namespace

BagReader::BagReader(std::unique_ptr<std::istream> stream, const std::filesystem::path& name)
    : stream_(std::move(stream)), name_(name) {
  stream_->seekg(0, std::ios::end);
  const auto end = stream_->tellg();
  if (!*stream_ || end < 0) Complain("cannot be read");
  size_ = static_cast<std::uint64_t>(end);
  stream_->seekg(0);
  if (size_ == 0) Complain("the file is empty");
  std::string magic(kMagic.size(), '\0');
  stream_->read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (magic != kMagic) Complain("not a ROS 1 bag of format 2.0");
  position_ = kMagic.size();
  ReadBagHeader();
}

void BagReader::Complain(const std::string& problem) const {
  throw InputError(name_, {}, "", problem);
}

std::string BagReader::ReadBlock() {
  std::string size_bytes(4, '\0');
  if (size_ - position_ < 4) Complain("the file is cut off");
  stream_->read(size_bytes.data(), 4);
  const auto size = Load<std::uint32_t>(size_bytes);
  position_ += 4;
  if (size > size_ - position_) Complain("the file is cut off");
  if (size > kLargestBlock) Complain("a part of it is larger than any that is recorded");
  std::string block(size, '\0');
  stream_->read(block.data(), static_cast<std::streamsize>(size));
  if (!*stream_) Complain("cannot be read");
  position_ += size;
  return block;
}

std::string_view BagReader::TakeBlock() {
  if (rest_.size() < 4) Complain("a chunk is damaged");
  const auto size = Load<std::uint32_t>(rest_);
  rest_.remove_prefix(4);
  if (size > rest_.size()) Complain("a chunk is damaged");
  const std::string_view block = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return block;
}

BagReader::Fields BagReader::Split(std::string_view header) const {
  Fields fields;
  while (!header.empty()) {
    if (header.size() < 4 || Load<std::uint32_t>(header) > header.size() - 4)
      Complain("a header is damaged");
    const std::string_view field = header.substr(4, Load<std::uint32_t>(header));
    header.remove_prefix(4 + field.size());
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) Complain("a header is damaged");
    fields[field.substr(0, equals)] = field.substr(equals + 1);
  }
  return fields;
}

std::string_view BagReader::TextIn(const Fields& fields, std::string_view name) const {
  const auto field = fields.find(name);
  if (field == fields.end()) Complain("a header lacks its \"" + std::string(name) + "\"");
  return field->second;
}

template <typename Number>
Number BagReader::NumberIn(const Fields& fields, std::string_view name) const {
  const std::string_view text = TextIn(fields, name);
  if (text.size() != sizeof(Number)) Complain("a header is damaged");
  return Load<Number>(text);
}

void BagReader::ReadBagHeader() {
  header_ = ReadBlock();
  const Fields fields = Split(header_);
  if (NumberIn<Op>(fields, "op") != Op::kBagHeader) Complain("not a ROS 1 bag");
  index_at_ = NumberIn<std::uint64_t>(fields, "index_pos");
  static_cast<void>(ReadBlock());  // padding
  if (index_at_ == 0)
    Complain("has no index, because the run broke off: `rosbag reindex` makes it readable");
  if (index_at_ > size_) Complain("the file is cut off");
  if (index_at_ < position_) Complain("a header is damaged");
  CheckIndex(NumberIn<std::uint32_t>(fields, "conn_count"),
             NumberIn<std::uint32_t>(fields, "chunk_count"));
}

void BagReader::CheckIndex(std::uint64_t connections, std::uint64_t chunks) {
  const std::uint64_t messages_at = std::exchange(position_, index_at_);
  stream_->seekg(static_cast<std::streamoff>(index_at_));
  std::uint64_t records = 0;
  for (; position_ < size_; ++records) {
    static_cast<void>(ReadBlock());
    static_cast<void>(ReadBlock());
  }
  if (records != connections + chunks) Complain("the file is cut off");
  position_ = messages_at;
  stream_->seekg(static_cast<std::streamoff>(position_));
}

bool BagReader::ReadChunk() {
  while (position_ < index_at_) {
    header_ = ReadBlock();
    chunk_ = ReadBlock();
    const Fields fields = Split(header_);
    const Op op = NumberIn<Op>(fields, "op");
    if (op == Op::kIndex) continue;
    if (op != Op::kChunk) Complain("a record stands where none should");
    if (TextIn(fields, "compression") != "none")
      Complain("is compressed: `rosbag decompress` makes it readable");
    rest_ = chunk_;
    return true;
  }
  return false;
}

void BagReader::Connect(const Fields& header, std::string_view data) {
  const Fields about = Split(data);
  connections_[NumberIn<std::uint32_t>(header, "conn")] = {std::string(TextIn(header, "topic")),
                                                           std::string(TextIn(about, "type")),
                                                           std::string(TextIn(about, "md5sum"))};
}

std::optional<BagMessage> BagReader::Next() {
  while (true) {
    if (rest_.empty() && !ReadChunk()) return std::nullopt;
    if (rest_.empty()) continue;
    const Fields header = Split(TakeBlock());
    const std::string_view data = TakeBlock();
    const Op op = NumberIn<Op>(header, "op");
    if (op == Op::kConnection) Connect(header, data);
    if (op != Op::kMessage) continue;
    const auto connection = connections_.find(NumberIn<std::uint32_t>(header, "conn"));
    if (connection == connections_.end()) Complain("a message belongs to no topic");
    const auto time = NumberIn<std::uint64_t>(header, "time");  // seconds below, nanoseconds above
    const RunTime at =
        std::chrono::seconds(time & 0xFFFFFFFFU) + std::chrono::nanoseconds(time >> 32);
    const Connection& from = connection->second;
    return BagMessage{from.topic, from.type, from.md5, at, data};
  }
}

}  // namespace kantaro::robot
