#pragma once

#include <string>
#include <string_view>

namespace ceilmap::page {

/// A text escaped for HTML, between tags or in an attribute in double quotes.
std::string EscapedForHtml(std::string_view text);

}  // namespace ceilmap::page
