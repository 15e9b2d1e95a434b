#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <string>

namespace ceilmap::fuzz {

/// A change or a few of a text or a binary file, such as damage and malice bring: bits turned,
/// bytes put in, runs left out, doubled or swapped for those of another file, numbers replaced by
/// extreme ones. The same on every machine for the same generator.
/// @param others  of which parts may be taken; not empty.
std::string Mutate(std::string bytes, std::span<const std::string> others, std::mt19937& random);

}  // namespace ceilmap::fuzz
