#pragma once

#include <gtest/gtest.h>

#include <string>

#include "calib/base/error.hpp"
#include "calib/rig.hpp"
#include "tests/calib/rig_text.hpp"

/// Rigs with a fault, and the messages of their reader.
namespace ceilmap::calib {

/// The message of the InputError that reading ends in; empty when it does not.
inline std::string ErrorOf(const std::string& text) {
  try {
    ParseRig(text, "rig.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// What makes the good rig a bad one.
struct Fault {
  const char* name;
  const char* from;  // text of the good rig
  const char* to;
  const char* message;  // whole
};

inline void ExpectNamed(const Fault& fault) {
  EXPECT_EQ(ErrorOf(Replaced(kRigText, fault.from, fault.to)), fault.message);
}

inline std::string NameOf(const ::testing::TestParamInfo<Fault>& test) {
  return test.param.name;
}

}  // namespace ceilmap::calib
