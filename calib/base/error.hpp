#pragma once

#include <stdexcept>

namespace ceilmap {

/// A file, setting or argument that cannot be used. The text is one line that states what is wrong,
/// where, and how to fix it; the program prints it and exits with 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input was usable, but the work could not be done (no texture, disk full, ...). The text is
/// one line as above; the program prints it and exits with 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace ceilmap
