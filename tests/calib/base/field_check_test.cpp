#include "calib/base/field_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"

namespace ceilmap {
namespace {

TEST(FieldCheck, NamesOwnerFieldValueAndRange) {
  const FieldCheck require("odometry");
  EXPECT_NO_THROW(require(true, "min_overlap", 0.5, "in (0, 1)"));
  EXPECT_THAT([&] { require(false, "min_overlap", 1.5, "in (0, 1)"); },
              testing::ThrowsMessage<InputError>("odometry: min_overlap = 1.5, must be in (0, 1)"));
}

}  // namespace
}  // namespace ceilmap
