#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <deque>
#include <optional>
#include <span>

namespace ceilmap::compensation {

/// Light of lamps on the mains in the rows of an image: the log of the grey values exposed at time
/// t is larger by Re(amplitude * exp(2 pi i frequency_hz (t - stamp_s))).
struct Bands {
  double frequency_hz = 0;
  double stamp_s = 0;
  std::complex<double> amplitude;

  [[nodiscard]] double LogGain(double time_s) const;
};

/// A point of the ceiling in two images.
struct BandSample {
  double log_ratio = 0;      ///< log of its grey value in the later image over that in the earlier
  double row_s = 0;          ///< exposure of its row in the later image, after the image's stamp
  double earlier_row_s = 0;  ///< the same in the earlier image
  double radius2 = 0;        ///< from the image's centre, squared; 1 in the corners
  double earlier_radius2 = 0;  ///< the same in the earlier image
};

/// Finds the bands that explain how the brightness of ceiling points differs between images, on
/// mains of 50 or 60 Hz. The structure of the ceiling cancels, so that no structure can be taken
/// for bands; a gain of each image and vignetting are eliminated. All pairs of the last seconds
/// have one amplitude and one frequency, whatever the rate of the images. Bands that stand still in
/// the rows are seen where the robot moves along them.
class BandFit {
 public:
  /// Two images of which more than a few dozen points are known; fewer are ignored.
  /// @param stamp_s, earlier_stamp_s  Of their middle rows.
  void Add(double stamp_s, double earlier_stamp_s, std::span<const BandSample> samples);

  /// The bands around the time of the last pair; nothing where there are none, or too weak to be
  /// distinguished from other changes of brightness.
  /// @param known  Whether bands were found after the pair before.
  [[nodiscard]] std::optional<Bands> Solve(bool known = false) const;

  void Clear() { pairs_.clear(); }

 private:
  /// Least squares of a pair in (amplitude in the later image, in the earlier one), each as real
  /// and imaginary part, at the time of the image's stamp.
  struct Quadratic {
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    /// The same without the errors that all points have in common.
    Eigen::Matrix4d of_points = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right_of_points = Eigen::Vector4d::Zero();
    double total = 0;  ///< squared residuals of the points without bands
  };
  static constexpr std::array kMainsHz{100.0, 120.0};
  struct Pair {
    double stamp_s = 0;
    double earlier_stamp_s = 0;
    std::array<Quadratic, kMainsHz.size()> by_mains;
  };
  struct Trial;
  [[nodiscard]] Trial Try(std::size_t mains, double frequency_hz) const;
  static Quadratic Reduce(std::span<const BandSample> samples, double frequency_hz);

  std::deque<Pair> pairs_;  // the latest last
};

}  // namespace ceilmap::compensation
