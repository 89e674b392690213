#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace kantaro {

/// Running SHA-256 (FIPS 180-4) over everything added, in order.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Add(std::span<const std::byte> bytes);
  /// The digest of what was added so far, as 64 hexadecimal digits; adding may go on.
  [[nodiscard]] std::string HexDigest() const;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace kantaro
