#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "robot/readings.hpp"

namespace kantaro::robot {

/// One message of a bag, in ROS' serialisation.
struct BagMessage {
  std::string_view topic, type, md5;
  RunTime at{};
  std::string_view data;
};

/// Reads a ROS 1 bag (format 2.0) from beginning to end, in the order in which it was written,
/// which rosbag's own reader does not keep among messages of one instant. Trusts nothing: every
/// length is checked against what is there, and no more is taken into memory than that.
/// http://wiki.ros.org/Bags/Format/2.0
class BagReader {
 public:
  /// @param name  what complaints call it.
  /// @throws InputError if this is no bag, has no index (its writer died), or is cut off.
  BagReader(std::unique_ptr<std::istream> stream, const std::filesystem::path& name);

  /// The next message; its views hold until the next call. Absent at the end.
  /// @throws InputError for a damaged or compressed bag.
  [[nodiscard]] std::optional<BagMessage> Next();

  /// What is wrong with this bag.
  [[noreturn]] void Complain(const std::string& problem) const;

 private:
  struct Connection {
    std::string topic, type, md5;
  };
  /// Fields of a record's header by name.
  using Fields = std::map<std::string_view, std::string_view>;

  [[nodiscard]] std::string ReadBlock();
  [[nodiscard]] std::string_view TakeBlock();
  [[nodiscard]] Fields Split(std::string_view header) const;
  template <typename Number>
  [[nodiscard]] Number NumberIn(const Fields& fields, std::string_view name) const;
  [[nodiscard]] std::string_view TextIn(const Fields& fields, std::string_view name) const;
  void ReadBagHeader();
  /// The index itself is not used, but that it is whole says that the file is.
  void CheckIndex(std::uint64_t connections, std::uint64_t chunks);
  /// @returns whether there was another.
  [[nodiscard]] bool ReadChunk();
  void Connect(const Fields& header, std::string_view data);

  std::unique_ptr<std::istream> stream_;
  std::filesystem::path name_;
  std::uint64_t size_{};        ///< of the bag
  std::uint64_t position_{};    ///< of the next record in it
  std::uint64_t index_at_{};    ///< where the messages end
  std::string header_, chunk_;  ///< of the record read last
  std::string_view rest_;       ///< of the chunk
  std::map<std::uint32_t, Connection> connections_;
};

}  // namespace kantaro::robot
