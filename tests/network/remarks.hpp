#pragma once

#include <algorithm>
#include <string>

#include "network/network.hpp"

namespace kantaro::network {

inline bool HasRemark(const Network& network, const std::string& subject, const std::string& text) {
  return std::any_of(network.remarks.begin(), network.remarks.end(), [&](const Remark& remark) {
    return remark.subject == subject && remark.text.find(text) != std::string::npos;
  });
}

}  // namespace kantaro::network
