#pragma once

#include <string>
#include <string_view>

namespace kantaro::scenarios {

/// Text made safe for HTML and SVG content and attributes: names come from other people's files.
/// Control characters and bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string Escape(std::string_view text);

/// RFC 4648, with padding, for data: addresses.
[[nodiscard]] std::string Base64(std::string_view bytes);

}  // namespace kantaro::scenarios
