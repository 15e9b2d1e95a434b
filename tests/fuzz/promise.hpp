#pragma once

#include <optional>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "calib/base/error.hpp"

namespace ceilmap::fuzz {

/// What a reader promises does not hold: a crash to libFuzzer, a failure to a test.
class BrokenPromise : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void Require(bool holds, const char* what) {
  if (!holds) throw BrokenPromise(what);
}

/// An error is one line that a terminal shows and does not obey, and that can be read at a glance.
inline void RequireOneLine(std::string_view message) {
  constexpr std::size_t kMaxBytes = 2000;
  Require(!message.empty() && message.size() <= kMaxBytes, "a message is empty or endless");
  for (const char c : message) {
    Require(static_cast<unsigned char>(c) >= ' ' && c != 127, "a message has control characters");
  }
}

/// What `read` gives, or nothing when it refuses its input by an InputError as it may. Every other
/// exception comes through.
template <typename Read>
std::optional<std::invoke_result_t<Read>> Accepted(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    RequireOneLine(error.what());
    return std::nullopt;
  }
}

}  // namespace ceilmap::fuzz
