#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/registration/registration.hpp"

namespace ceilmap::registration::synthetic {

struct CeilingParams {
  std::uint32_t seed = 1;
  double tile_px = 110;                      ///< side of the square tiles; 0: no tiles
  double tile_grey = 5;                      ///< brightness differs by up to this from tile to tile
  double groove_grey = 35;                   ///< depth of the dark lines between the tiles
  double speckle_grey = 14;                  ///< height of the grain of the surface, light and dark
  bool lamps = true;                         ///< bright strips, about one in 300 x 300 px
  bool marks = true;                         ///< dark spots, about one in 160 x 160 px
  std::vector<Eigen::Vector2d> own_marks{};  ///< large dark spots at these places
};

/// A ceiling without end, drawn from formulas: every image of it is exact under any similarity
/// motion, no image is made by resampling another. All it consists of has been smoothed by a
/// Gaussian of at least 1.2 px, so that sampling at one pixel (or 0.7) loses nothing.
class SyntheticCeiling {
 public:
  explicit SyntheticCeiling(const CeilingParams& params = {}) : params_(params) {}

  /// What a camera shows to which ceiling point p (pixels) appears at motion.Apply(p) from the
  /// image's centre, in grey levels, CV_32FC1. With the motions A and B of two images,
  /// Compose(B, A.Inverse()) is the motion from the first to the second.
  [[nodiscard]] cv::Mat RenderFloat(cv::Size size, const ImageMotion& motion = {}) const {
    cv::Mat image(size, CV_32FC1, cv::Scalar(130));
    const Frame frame{size, motion, motion.Inverse()};
    if (params_.tile_px > 0) DrawTiles(frame, image);
    if (params_.speckle_grey > 0) {
      DrawSpots(frame, {1, 8, 1.0, 1.3, 2.3, params_.speckle_grey, true}, image);
    }
    if (params_.marks) DrawSpots(frame, {2, 160, 0.8, 4, 9, -60, false}, image);
    for (const Eigen::Vector2d& p : params_.own_marks) {
      AddSpot(motion.Apply(p), 12 * motion.scale, -70, image);
    }
    if (params_.lamps) DrawLamps(frame, image);
    return image;
  }

  /// The same in 8 bits, with white noise of a standard deviation (grey levels).
  [[nodiscard]] cv::Mat Render(cv::Size size,
                               const ImageMotion& motion = {},
                               double noise_sigma = 0,
                               std::uint32_t noise_seed = 1) const {
    cv::Mat image = RenderFloat(size, motion);
    if (noise_sigma > 0) {
      cv::Mat noise(size, CV_32FC1);
      cv::RNG random(noise_seed * 2654435761U + 97);
      random.fill(noise, cv::RNG::NORMAL, 0, noise_sigma);
      image += noise;
    }
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return grey;
  }

 private:
  struct Frame {
    cv::Size size;
    ImageMotion motion;   // ceiling -> image
    ImageMotion inverse;  // image -> ceiling

    [[nodiscard]] Eigen::Vector2d Centred(double u, double v) const {
      return {u - 0.5 * (size.width - 1), v - 0.5 * (size.height - 1)};
    }
  };

  /// Gaussian spots, at most one in each cell of a square grid.
  struct Spots {
    std::uint32_t layer;
    double cell_px;
    double probability;
    double sigma_min_px;
    double sigma_max_px;
    double grey;
    bool both_signs;
  };

  struct Cells {
    int x0, x1, y0, y1;
  };

  /// Four independent numbers in [0, 1) that belong to a cell.
  [[nodiscard]] std::array<double, 4> Chance(std::uint32_t layer, int x, int y) const {
    std::uint64_t state = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32U) |
                          static_cast<std::uint32_t>(y);
    state ^= (static_cast<std::uint64_t>(params_.seed) * 16 + layer) * 0x9E3779B97F4A7C15ULL;
    std::array<double, 4> numbers{};
    for (double& number : numbers) {  // splitmix64
      state += 0x9E3779B97F4A7C15ULL;
      std::uint64_t z = state;
      z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
      z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
      z ^= z >> 31U;
      number = static_cast<double>(z >> 11U) * 0x1.0p-53;
    }
    return numbers;
  }

  /// Cells that the image may show, with one more on each side.
  static Cells CellsInView(const Frame& frame, double cell_px) {
    double reach_x = 0;
    double reach_y = 0;
    const Eigen::Vector2d centre = frame.inverse.Apply({0, 0});
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector2d corner =
          frame.inverse.Apply({0.5 * frame.size.width, sign * 0.5 * frame.size.height}) - centre;
      reach_x = std::max(reach_x, std::abs(corner.x()));
      reach_y = std::max(reach_y, std::abs(corner.y()));
    }
    const auto cell = [&](double at) { return static_cast<int>(std::floor(at / cell_px)); };
    return {cell(centre.x() - reach_x) - 1,
            cell(centre.x() + reach_x) + 1,
            cell(centre.y() - reach_y) - 1,
            cell(centre.y() + reach_y) + 1};
  }

  static void AddSpot(const Eigen::Vector2d& at, double sigma, double grey, cv::Mat& image) {
    // A Gaussian is the product of one along x and one along y, in any rotation.
    const double u = at.x() + 0.5 * (image.cols - 1);
    const double v = at.y() + 0.5 * (image.rows - 1);
    const double reach = 4.5 * sigma;
    const int x0 = std::max(0, static_cast<int>(std::ceil(u - reach)));
    const int x1 = std::min(image.cols - 1, static_cast<int>(std::floor(u + reach)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(v - reach)));
    const int y1 = std::min(image.rows - 1, static_cast<int>(std::floor(v + reach)));
    std::array<float, 256> along_x{};
    if (x1 - x0 >= static_cast<int>(along_x.size())) return;
    const double k = -0.5 / (sigma * sigma);
    for (int x = x0; x <= x1; ++x) {
      along_x[static_cast<std::size_t>(x - x0)] =
          static_cast<float>(std::exp(k * (x - u) * (x - u)));
    }
    for (int y = y0; y <= y1; ++y) {
      const auto height = static_cast<float>(grey * std::exp(k * (y - v) * (y - v)));
      auto* row = image.ptr<float>(y);
      for (int x = x0; x <= x1; ++x) row[x] += height * along_x[static_cast<std::size_t>(x - x0)];
    }
  }

  void DrawSpots(const Frame& frame, const Spots& spots, cv::Mat& image) const {
    const Cells cells = CellsInView(frame, spots.cell_px);
    for (int j = cells.y0; j <= cells.y1; ++j) {
      for (int i = cells.x0; i <= cells.x1; ++i) {
        const auto place = Chance(2 * spots.layer, i, j);
        const auto kind = Chance(2 * spots.layer + 1, i, j);
        if (place[2] >= spots.probability) continue;
        const Eigen::Vector2d p((i + place[0]) * spots.cell_px, (j + place[1]) * spots.cell_px);
        const double sigma =
            spots.sigma_min_px + kind[0] * (spots.sigma_max_px - spots.sigma_min_px);
        const double grey =
            spots.both_signs ? spots.grey * (2 * kind[1] - 1) : spots.grey * (0.5 + 0.5 * kind[1]);
        AddSpot(frame.motion.Apply(p), frame.motion.scale * sigma, grey, image);
      }
    }
  }

  /// A step from 0 to 1 at `x` = 0, smoothed.
  static double Step(double x) {
    constexpr double kSigma = 1.3;
    if (x < -5 * kSigma) return 0;
    if (x > 5 * kSigma) return 1;
    return 0.5 * std::erfc(-x / (kSigma * std::sqrt(2.0)));
  }

  void DrawTiles(const Frame& frame, cv::Mat& image) const {
    constexpr double kGroove = 1.4;  // half width of the lines, sigma
    const auto groove = [](double d) {
      return std::abs(d) > 5 * kGroove ? 0.0 : std::exp(-0.5 * d * d / (kGroove * kGroove));
    };
    const auto tile_grey = [&](int i, int j) {
      return params_.tile_grey * (2 * Chance(0, i, j)[0] - 1);
    };
    for (int v = 0; v < image.rows; ++v) {
      auto* row = image.ptr<float>(v);
      int i_known = 0;
      int j_known = 0;
      std::array<double, 4> greys{};
      bool known = false;
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector2d p = frame.inverse.Apply(frame.Centred(u, v));
        // The nearest crossing of lines, and the four tiles around it.
        const int i = static_cast<int>(std::lround(p.x() / params_.tile_px));
        const int j = static_cast<int>(std::lround(p.y() / params_.tile_px));
        const double dx = p.x() - i * params_.tile_px;
        const double dy = p.y() - j * params_.tile_px;
        if (!known || i != i_known || j != j_known) {
          greys = {
              tile_grey(i - 1, j - 1), tile_grey(i, j - 1), tile_grey(i - 1, j), tile_grey(i, j)};
          i_known = i;
          j_known = j;
          known = true;
        }
        const double right = Step(dx);
        const double down = Step(dy);
        const double upper = greys[0] + right * (greys[1] - greys[0]);
        const double lower = greys[2] + right * (greys[3] - greys[2]);
        row[u] += static_cast<float>(upper + down * (lower - upper) -
                                     params_.groove_grey * std::max(groove(dx), groove(dy)));
      }
    }
  }

  void DrawLamps(const Frame& frame, cv::Mat& image) const {
    constexpr double kCell = 300;
    const Cells cells = CellsInView(frame, kCell);
    for (int j = cells.y0; j <= cells.y1; ++j) {
      for (int i = cells.x0; i <= cells.x1; ++i) {
        const auto place = Chance(6, i, j);
        if (place[3] > 0.7) continue;
        const bool upright = place[2] < 0.5;
        const Eigen::Vector2d half(upright ? 12 : 55, upright ? 55 : 12);
        AddLamp(frame,
                {(i + 0.2 + 0.6 * place[0]) * kCell, (j + 0.2 + 0.6 * place[1]) * kCell},
                half,
                image);
      }
    }
  }

  static void AddLamp(const Frame& frame,
                      const Eigen::Vector2d& centre,
                      const Eigen::Vector2d& half,
                      cv::Mat& image) {
    const Eigen::Vector2d at = frame.motion.Apply(centre) - frame.Centred(0, 0);
    const double reach = frame.motion.scale * (half.norm() + 8);
    const int x0 = std::max(0, static_cast<int>(at.x() - reach));
    const int x1 = std::min(image.cols - 1, static_cast<int>(at.x() + reach));
    const int y0 = std::max(0, static_cast<int>(at.y() - reach));
    const int y1 = std::min(image.rows - 1, static_cast<int>(at.y() + reach));
    for (int v = y0; v <= y1; ++v) {
      auto* row = image.ptr<float>(v);
      for (int u = x0; u <= x1; ++u) {
        const Eigen::Vector2d p = frame.inverse.Apply(frame.Centred(u, v)) - centre;
        row[u] += static_cast<float>(70 * Step(half.x() - std::abs(p.x())) *
                                     Step(half.y() - std::abs(p.y())));
      }
    }
  }

  CeilingParams params_;
};

/// Motion under which the upward camera of a robot at T_map_base shows the ceiling, for Render: the
/// ceiling's pixels are p_map / m_per_px.
inline ImageMotion MotionAt(const calib::CeilingView& view, const Pose2& T_map_base) {
  const Pose2 T_view_map = (T_map_base * view.T_base_view()).Inverse();
  return {T_view_map.x / view.MetresPerPixel(),
          T_view_map.y / view.MetresPerPixel(),
          T_view_map.yaw,
          1.0};
}

/// Length of the difference of two motions' translations, pixels.
inline double ShiftError(const ImageMotion& a, const ImageMotion& b) {
  return std::hypot(a.tx_px - b.tx_px, a.ty_px - b.ty_px);
}

/// Angle between two motions' rotations, degrees, >= 0.
inline double AngleErrorDeg(const ImageMotion& a, const ImageMotion& b) {
  return std::abs(WrapAngle(a.theta_rad - b.theta_rad)) * 57.29577951308232;
}

}  // namespace ceilmap::registration::synthetic
