#pragma once

#include <stdexcept>

namespace ceilmap::bags {

/// A message that cannot be decoded. The text says what is wrong with it; who reads the bag adds
/// the file, the topic and the time.
class MessageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace ceilmap::bags
