#pragma once

#include <string>
#include <string_view>

namespace ceilmap::site {

/// A word for a POSIX shell, which stands for exactly this text: 'it'\''s'. Also safe for a text
/// with line breaks.
std::string ShellWord(std::string_view text);

/// The same in a recipe of a makefile, where make expands `$`.
/// @throws InputError when the text has a line break, which would end the recipe.
std::string RecipeWord(std::string_view text);

/// The name of a file as target or prerequisite of a makefile.
/// @throws InputError when GNU make cannot express it.
std::string MakeName(std::string_view file);

}  // namespace ceilmap::site
