#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/noise.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Single features on the texture of the ceiling: stains, which darken it, then plain parts and
/// marks, which cover it.
class CeilingFeatures {
 public:
  explicit CeilingFeatures(const Scene& scene);

  /// Draws features that touch the grid. @param light  CV_32FC1 of the grid's size.
  void Draw(const SampleGrid& grid, cv::Mat& light) const;

 private:
  enum class Shape { kDisc, kRing, kBar, kStain, kPlain };
  struct Feature {
    Shape shape = Shape::kDisc;
    double x_m = 0;
    double y_m = 0;
    double radius_m = 0;
    double angle_rad = 0;
    double brightness = 0;     // of a mark; depth of a stain
    double half_length_m = 0;  // of a plain part, along x
    double half_width_m = 0;
    [[nodiscard]] double Reach() const;
    /// Signed distance of a mark's outline in metres, < 0 inside.
    [[nodiscard]] double Distance(double dx, double dy) const;
    /// Factor of the light under a stain.
    [[nodiscard]] double Remaining(double dx, double dy) const;
  };
  static void DrawOne(const Feature& feature, const SampleGrid& grid, cv::Mat& light);
  void AddStains(const Scene& scene);
  void AddPlainParts(const Ceiling& ceiling);
  void AddMarks(const Scene& scene);

  std::vector<Feature> features_;
};

}  // namespace ceilmap::simulator
