#pragma once

#include <string_view>

namespace ceilmap::page {

/// page.html with its styles, its scripts and the libraries in their places, made when the program
/// is built (cmake/embed_page.cmake). In it, in this order, `{{connect}}`, `{{title}}` and
/// `{{document}}` are to be replaced.
std::string_view PageTemplate();

}  // namespace ceilmap::page
