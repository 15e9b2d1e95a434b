#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace ceilmap::simulator {

/// A part of a plane sampled on a grid: sample (row, column) lies at x = (column0 + column + 0.5) *
/// pitch_x, y likewise.
struct SampleGrid {
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;
  double pitch_x_m = 0.01;
  double pitch_y_m = 0.01;
  int columns = 0;
  int rows = 0;

  [[nodiscard]] double X(int column) const {
    return (static_cast<double>(column0 + column) + 0.5) * pitch_x_m;
  }
  [[nodiscard]] double Y(int row) const {
    return (static_cast<double>(row0 + row) + 0.5) * pitch_y_m;
  }
};

/// Adds smooth noise of mean 0 and the given standard deviation to `samples` (CV_32FC1 of the
/// grid's size): a cubic B-spline over random values at the corners of square cells. A position has
/// the same value in every grid.
/// @param key  Seed. @param cell_m  Size of the cells; below two samples the noise is attenuated.
/// @param period_cells  Period in cells in x and y; 0: none.
void AddSplineNoise(std::uint64_t key,
                    double cell_m,
                    double deviation,
                    const SampleGrid& grid,
                    cv::Mat& samples,
                    std::int64_t period_cells = 0);

/// Periodic samples, bilinearly interpolated: `column` and `row` count samples and may be negative.
/// @param samples  CV_32FC1, width and height a power of two.
float SamplePeriodic(const cv::Mat& samples, double column, double row);

/// Adds the texture of mineral fibre: dark pits of 2 to 12 mm in all directions on a fine mottle,
/// mean 0, standard deviation 1 in samples 4 mm apart. A function of the key and the position only:
/// finer samples show the same pits deeper and sharper, coarser ones their mean, which vanishes.
void AddGrain(std::uint64_t key, const SampleGrid& grid, cv::Mat& samples);

}  // namespace ceilmap::simulator
