#pragma once

#include <string>

#include "base/sha256.hpp"
#include "navigation/executive.hpp"
#include "robot/readings.hpp"

namespace kantaro::scenarios {

/// SHA-256 over a run: every reading (image bytes included), command and estimate, each marked by
/// its kind, in order.
class TraceHash {
 public:
  void Add(const robot::Reading& reading);
  void Add(const robot::Command& command);
  void Add(const navigation::Estimate& estimate);
  [[nodiscard]] std::string HexDigest() const { return sha_.HexDigest(); }

 private:
  Sha256 sha_;
};

}  // namespace kantaro::scenarios
