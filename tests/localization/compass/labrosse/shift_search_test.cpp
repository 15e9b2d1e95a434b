#include "localization/compass/labrosse/shift_search.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "calib/base/error.hpp"

namespace ceilmap::labrosse {
namespace {

/// Columns from `at`, in the shorter direction.
int Off(int shift, int at, int columns) {
  const int off = std::abs(shift - at) % columns;
  return std::min(off, columns - off);
}

TEST(ShiftSearch, GoesDownhillAroundTheCircle) {
  for (const int at : {0, 3, 180, 357}) {
    const auto distance = [&](int shift) { return 2.0 * Off(shift, at, 360); };
    for (const int from : {-25, 0, 40, 100}) {
      const FoundShift found = FindShift(distance, 360, at + from);
      EXPECT_EQ(found.columns, at);
      EXPECT_EQ(found.distances.left, 2);
      EXPECT_EQ(found.distances.least, 0);
      EXPECT_EQ(found.distances.right, 2);
      EXPECT_EQ(found.depth, 1);
    }
  }
}

// A valley of depth 50 at shift 0, the deep one at shift `to`, a ridge between them.
TEST(ShiftSearch, ProbesEscapeALocalMinimum) {
  const auto landscape = [](int to) {
    return [to](int shift) {
      return std::min(50.0 + 10 * Off(shift, 0, 360), 12.0 * Off(shift, to, 360));
    };
  };
  for (const int to : {-13, -8, 8, 13}) {
    EXPECT_EQ(FindShift(landscape(to), 360, 0).columns, to);
  }
  // Probes reach 10 deg; beyond, the other valley's floor is not seen.
  EXPECT_EQ(FindShift(landscape(20), 360, 0).columns, 0);
  EXPECT_EQ(FindShift(landscape(20), 360, 0, 40 * kRadPerDeg).columns, 20);
}

TEST(ShiftSearch, ProbesAreEvenlySpreadAndAskedOnce) {
  std::map<int, int> asked;
  const auto distance = [&](int shift) {
    ++asked[shift];
    return Off(shift, 100, 720) + 1.0;
  };
  const FoundShift found = FindShift(distance, 720, 100);
  const std::map<int, int> expected{{80, 1},
                                    {85, 1},
                                    {90, 1},
                                    {95, 1},
                                    {99, 1},
                                    {100, 1},
                                    {101, 1},
                                    {105, 1},
                                    {110, 1},
                                    {115, 1},
                                    {120, 1}};
  EXPECT_EQ(asked, expected);
  EXPECT_DOUBLE_EQ(found.depth, 20.0 / 21);
}

// Values passed during the descent do not count.
TEST(ShiftSearch, DepthDoesNotDependOnTheStart) {
  const auto distance = [](int shift) { return 5.0 + Off(shift, 200, 360); };
  EXPECT_EQ(FindShift(distance, 360, 60).depth, FindShift(distance, 360, 200).depth);
  EXPECT_DOUBLE_EQ(FindShift(distance, 360, 200).depth, 10.0 / 15);
}

TEST(ShiftSearch, EndsOnPlainsAndNarrowPanoramas) {
  const FoundShift flat = FindShift([](int) { return 4.0; }, 360, 17);
  EXPECT_EQ(flat.columns, 17);
  EXPECT_EQ(flat.depth, 0);
  const FoundShift narrow = FindShift([](int shift) { return Off(shift, 5, 8) + 1.0; }, 8, 1);
  EXPECT_EQ((narrow.columns + 8) % 8, 5);
}

}  // namespace
}  // namespace ceilmap::labrosse
