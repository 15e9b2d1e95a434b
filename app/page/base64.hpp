#pragma once

#include <string>
#include <vector>

namespace ceilmap::page {

/// RFC 4648, with padding, as in a data URL.
std::string Base64(const std::vector<unsigned char>& bytes);

}  // namespace ceilmap::page
