#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

/// Heights of a ceiling that is not one plane.
///
/// All heights are given as inverse ratios rho = Z_0 / Z: Z is the height of a point above the
/// camera, Z_0 that of the reference plane, whose height the rig states. rho = 1 on the reference
/// plane, > 1 below it. The image of a point moves by rho times what the image of the plane moves.
namespace ceilmap::heights {

/// Inverse height ratio of one place on the ceiling.
struct HeightCell {
  float rho = 1;
  float sigma = 0;  ///< standard deviation of rho; kUnknown: nothing is known
};

/// What is assumed of a place that was never measured: between the reference plane and two thirds
/// of its height.
inline constexpr HeightCell kUnknown{1.15F, 0.25F};
inline constexpr double kUnknownScale = 0.15;
/// A cell whose standard deviation is below this value is measured.
inline constexpr float kMeasuredSigma = 0.08F;

/// Inverse height ratios of a ceiling on a grid of cells over one image.
struct HeightField {
  cv::Size grid;  ///< columns, rows
  /// Centre of the first cell and distances of columns and rows, pixels from the image's centre.
  Eigen::Vector2d first_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d step_px = Eigen::Vector2d::Ones();
  std::vector<HeightCell> cells;  ///< row by row
  /// Standard deviation of the scale that all ratios have in common: how well it is known which of
  /// them belong to the plane whose height the rig states.
  double scale_sigma = kUnknownScale;

  [[nodiscard]] bool empty() const { return cells.empty(); }
  [[nodiscard]] Eigen::Vector2d Centre(std::size_t cell) const;
  /// Index of the cell whose centre is nearest; nothing outside the grid by more than half a cell.
  [[nodiscard]] std::optional<std::size_t> CellAt(const Eigen::Vector2d& x_px) const;
  /// The ratio at a point: that of the most accurate of the 3x3 cells around it.
  [[nodiscard]] HeightCell Around(const Eigen::Vector2d& x_px) const;
  /// Fraction of the measured cells that are clearly below the reference plane, 0..1, less those
  /// that are clearly above it: nothing hangs there, and errors of matches in blurred images go
  /// both ways.
  [[nodiscard]] double DepthRatio() const;
  /// Fraction of the measured cells that are clearly off their median, 0..1: how far the ceiling
  /// is from one plane, whatever the scale of the ratios.
  [[nodiscard]] double UnevenRatio() const;
  /// Multiplies all ratios.
  void Scale(double factor);
};

/// Ratio of the reference plane among measured ratios: the farthest surface (the lowest in rho)
/// that covers a large part of the ceiling; among surfaces within a few per cent, such as a deck
/// and its skylights, the farthest whose area is comparable to the largest. Nothing where no
/// surface stands out.
std::optional<double> FindReference(const std::vector<HeightCell>& cells);

/// Corrects the scale of a new reference's heights, which were predicted from those of the one
/// before, by the reference plane where it is seen: errors of the scale would grow from one to the
/// next. A plane that is too far off for the known uncertainty is another surface, and only that
/// uncertainty grows.
void PullToReference(HeightField& field);

/// The field as another image sees it. @param moved  takes a point of this image with its ratio to
/// the other image. Cells that no point of this field reaches are kUnknown. Ratios of a level robot
/// do not change from image to image.
/// @param blank  grid of the result.
HeightField Predict(const HeightField& from,
                    const HeightField& blank,
                    const std::function<Eigen::Vector2d(const Eigen::Vector2d&, double)>& moved);

}  // namespace ceilmap::heights
