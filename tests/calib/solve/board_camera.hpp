#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/board_projection.hpp"

namespace ceilmap::calibration {

/// What a real image has besides its content.
struct ImageFaults {
  double blur_px = 0.6;      ///< standard deviation of the lens's blur
  double vignetting = 0.35;  ///< loss of light at the farthest corner of the image, 0 to 1
  double noise = 2;          ///< standard deviation, grey values
};

/// Images of a printed chessboard through any lens, also beyond 90 degrees from its axis. Where a
/// pixel is not on one square, 64 points of it are averaged.
class BoardCamera {
 public:
  BoardCamera(const Board& board, const Lens& lens, const ImageFaults& faults = {});

  /// @param pose  of the board: origin at the corner where its upper left four squares meet.
  /// @param seed  of the noise. @return CV_8UC1; black where the lens shows nothing.
  [[nodiscard]] cv::Mat Take(const BoardPose& pose, std::uint64_t seed) const;

  /// Exact pixels of all corners; nothing for those that the lens does not show.
  [[nodiscard]] std::vector<std::optional<cv::Point2d>> Corners(const BoardPose& pose) const;

  /// True when the board with its white border is completely in the image.
  [[nodiscard]] bool Shows(const BoardPose& pose) const;

  /// Views as a person takes them, tilted to all sides by up to 35 degrees: in turn near the lens,
  /// at the rim of the image, and smaller in a corner, the latter two as far out as the image shows
  /// the board whole.
  [[nodiscard]] std::vector<BoardPose> Poses(int count) const;

 private:
  /// The image of the light on the pixels, with the faults.
  [[nodiscard]] cv::Mat Develop(cv::Mat1f light, std::uint64_t seed) const;
  /// Grey value of a place on the board's plane.
  [[nodiscard]] double Shade(double x_m, double y_m) const;

  Board board_;
  Lens lens_;
  ImageFaults faults_;
  cv::Mat_<cv::Vec3d> rays_;  // zero where the lens shows nothing
};

/// A lens whose half diagonal, 0.5 hypot(W, H), shows the given angle from the axis, rad. Its
/// centre is 2 and 3 px off that of the image.
Lens WideLens(LensModel model,
              cv::Size size,
              const std::vector<double>& coefficients,
              double half_diagonal_rad);

/// Names of the lenses of the tests and of the bench.
struct NamedLens {
  std::string name;
  Lens lens;
};
/// Equidistant lenses of 120 to 180 degrees, rational ones of 90 to 150 degrees.
std::vector<NamedLens> WideLenses(cv::Size size);

/// Accuracy of detected corners, by their distance from the image's centre.
struct CornerErrors {
  static constexpr int kRings = 4;  ///< of equal width, to the image's corners
  struct Ring {
    double squares_px2 = 0;
    double largest_px = 0;
    int count = 0;
  };
  std::vector<Ring> rings = std::vector<Ring>(kRings);
  int missed = 0;  ///< corners that were not found on boards that were
  /// @param truth  Corners of the pose. The board may be read from its other end.
  void Add(const BoardView& view,
           const std::vector<std::optional<cv::Point2d>>& truth,
           cv::Size size);
  [[nodiscard]] double Rms() const;
};

/// How far a calibrated lens is from the true one: over all pixels that the true lens shows, on a
/// grid of 8 px, the distance between the pixel and where the calibrated lens shows its ray.
struct LensError {
  double rms_px = 0;
  double largest_px = 0;
};
LensError CompareLenses(const Lens& calibrated, const Lens& truth);

}  // namespace ceilmap::calibration
