#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace ceilmap {

/// Levenshtein's distance: characters to insert, delete or replace.
std::size_t EditDistance(std::string_view a, std::string_view b);

/// The known word that a mistyped one most likely means, the first of equally similar ones; empty
/// when none is similar (a distance of two, or of a third of the word if that is more).
std::string SimilarWord(std::string_view word, const std::vector<std::string>& known);

/// `; did you mean 'KNOWN'?`, or only `;` when no word is similar: stands in a message before the
/// hint where the known words are listed.
std::string DidYouMean(std::string_view word, const std::vector<std::string>& known);

}  // namespace ceilmap
