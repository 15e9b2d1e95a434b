#pragma once

#include <string_view>

/// Texts that are compiled in from Markdown files (cmake/embed_text.cmake).
namespace ceilmap::commands {

/// app/FILES.md
std::string_view FilesText();
/// The section "Troubleshooting" of app/README.md, without its heading.
std::string_view TroubleshootingText();

}  // namespace ceilmap::commands
