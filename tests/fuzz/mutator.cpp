#include "tests/fuzz/mutator.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace ceilmap::fuzz {
namespace {

// std::uniform_int_distribution differs between standard libraries.
std::size_t Below(std::size_t count, std::mt19937& random) {
  return count == 0 ? 0 : random() % count;
}

struct Run {
  std::size_t at = 0;
  std::size_t size = 0;
};

// Short ones mostly.
Run RunOf(const std::string& bytes, std::mt19937& random) {
  const std::size_t at = Below(bytes.size() + 1, random);
  const std::size_t most = Below(4, random) == 0 ? bytes.size() : 8;
  return {at, std::min(Below(most + 1, random), bytes.size() - at)};
}

std::string_view Extreme(std::mt19937& random) {
  static constexpr std::array<std::string_view, 24> kTexts = {
      "0",     "-1",       "nan",       "inf", "1e308", "-1e-320", "99999999999999999999",
      "[",     "]",        "{",         "}",   "\"",    "'",       "&a ",
      "*a",    ",",        ":",         "\n",  "\r\n",  "#",       "---\n",
      "\x1b[", "\xff\xfe", "2147483648"};
  return kTexts[Below(kTexts.size(), random)];
}

void ReplaceNumber(std::string& bytes, std::mt19937& random) {
  constexpr std::string_view kDigits = "0123456789.";
  const std::size_t from = Below(bytes.size() + 1, random);
  const std::size_t begin = bytes.find_first_of(kDigits, from);
  if (begin == std::string::npos) return;
  const std::size_t end = std::min(bytes.find_first_not_of(kDigits, begin), bytes.size());
  bytes.replace(begin, end - begin, Extreme(random));
}

void ChangeOnce(std::string& bytes, std::span<const std::string> others, std::mt19937& random) {
  const Run run = RunOf(bytes, random);
  switch (Below(8, random)) {
    case 0:
      if (run.at < bytes.size()) bytes[run.at] ^= static_cast<char>(1U << Below(8, random));
      break;
    case 1:
      bytes.insert(run.at, 1, static_cast<char>(Below(256, random)));
      break;
    case 2:
      bytes.erase(run.at, run.size);
      break;
    case 3:
      bytes.insert(run.at, bytes.substr(run.at, run.size));
      break;
    case 4: {
      const std::string& other = others[Below(others.size(), random)];
      const Run theirs = RunOf(other, random);
      bytes.replace(run.at, run.size, other, theirs.at, theirs.size);
      break;
    }
    case 5:
      bytes.insert(run.at, Extreme(random));
      break;
    case 6:
      bytes.resize(run.at);
      break;
    default:
      ReplaceNumber(bytes, random);
  }
}

}  // namespace

std::string Mutate(std::string bytes, std::span<const std::string> others, std::mt19937& random) {
  constexpr std::size_t kMaxBytes = 1U << 16U;
  for (std::size_t changes = 1 + Below(4, random); changes > 0; --changes) {
    ChangeOnce(bytes, others, random);
  }
  if (bytes.size() > kMaxBytes) bytes.resize(kMaxBytes);
  return bytes;
}

}  // namespace ceilmap::fuzz
