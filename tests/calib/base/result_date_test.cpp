#include "calib/base/result_date.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

namespace ceilmap {
namespace {

TEST(ResultDate, IsTheOneOfTheEnvironment) {
  setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
  EXPECT_EQ(FixedResultDate(), "2023-11-14T22:13:20Z");
  EXPECT_EQ(ResultDate(), "2023-11-14T22:13:20Z");
  setenv("SOURCE_DATE_EPOCH", "0", 1);
  EXPECT_EQ(FixedResultDate(), "1970-01-01T00:00:00Z");
  setenv("SOURCE_DATE_EPOCH", "253402300799", 1);
  EXPECT_EQ(FixedResultDate(), "9999-12-31T23:59:59Z");
  for (const char* const wrong :
       {"", "-1", "1e9", " 1", "1 ", "253402300800", "99999999999999999999"}) {
    setenv("SOURCE_DATE_EPOCH", wrong, 1);
    EXPECT_EQ(FixedResultDate(), std::nullopt) << wrong;
  }
  unsetenv("SOURCE_DATE_EPOCH");
  EXPECT_EQ(FixedResultDate(), std::nullopt);
  EXPECT_GT(ResultDate(), "2024-01-01T00:00:00Z");
}

}  // namespace
}  // namespace ceilmap
