// Registers two images of one ceiling with the installed libraries and turns the result into a
// motion of the robot.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/registration/registrar.hpp"

namespace {

struct Blob {
  double u;
  double v;
  double sigma;
  double grey;
};

std::vector<Blob> MakeCeiling() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Blob> blobs(500);
  for (Blob& blob : blobs) {
    blob = {500 * unit(random) - 80,
            400 * unit(random) - 80,
            1.5 + 3 * unit(random),
            160 * unit(random) - 80};
  }
  return blobs;
}

cv::Mat Photograph(const std::vector<Blob>& ceiling, double shift_u, double shift_v) {
  cv::Mat_<double> image(240, 320, 120.0);
  for (const Blob& blob : ceiling) {
    for (int v = 0; v < image.rows; ++v) {
      const double dv = v - blob.v - shift_v;
      if (std::abs(dv) > 5 * blob.sigma) continue;
      for (int u = 0; u < image.cols; ++u) {
        const double du = u - blob.u - shift_u;
        const double r2 = du * du + dv * dv;
        image(v, u) += blob.grey * std::exp(-0.5 * r2 / (blob.sigma * blob.sigma));
      }
    }
  }
  cv::Mat grey;
  image.convertTo(grey, CV_8U);
  return grey;
}

}  // namespace

int main() {
  const auto view = ceilmap::calib::CeilingView::InPixels({320, 240});
  const std::vector<Blob> ceiling = MakeCeiling();
  ceilmap::registration::Registrar registrar(view.Size());
  const auto reference = registrar.Analyze(Photograph(ceiling, 0, 0));
  const auto current = registrar.Analyze(Photograph(ceiling, 0, 12.25));
  const auto registration = registrar.Register(reference, current);
  const auto& motion = registration.motion;
  if (!registration.ok() || std::hypot(motion.tx_px, motion.ty_px - 12.25) > 0.05) {
    std::printf(
        "wrong: %s, %.3f, %.3f px\n", ToString(registration.verdict), motion.tx_px, motion.ty_px);
    return EXIT_FAILURE;
  }
  // Content that moves down the image is passed by a robot that drives forward.
  const Eigen::Vector2d ahead =
      view.T_base_view().Rotation() * -Eigen::Vector2d(motion.tx_px, motion.ty_px);
  std::printf("drove ahead by %.2f px\n", ahead.x());
  return ahead.x() > 12 ? EXIT_SUCCESS : EXIT_FAILURE;
}
