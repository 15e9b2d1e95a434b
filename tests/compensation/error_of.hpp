#pragma once

#include <gtest/gtest.h>

#include <string>

#include "calib/base/error.hpp"

namespace ceilmap::compensation::synthetic {

/// The text of the InputError that `call` throws; a failure when it throws none.
template <typename Call>
std::string ErrorOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return {};
}

}  // namespace ceilmap::compensation::synthetic
