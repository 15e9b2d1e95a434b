#include "mapping/registration/plane_measurement.hpp"

#include <algorithm>
#include <utility>

namespace ceilmap::registration {
namespace {

constexpr int kFirstPlaneBlocks = 24;  // of the first round
// Distances within which the peak of a block is searched, pixels of the level: in the first round,
// and from a motion that was fitted.
constexpr int kFarPx = 16;
constexpr int kNearPx = 4;

}  // namespace

/// Maximum distance between the images of the corners under two motions, pixels of the level.
double PlaneMeasurement::CornerStep(const PlaneMotion& a, const PlaneMotion& b) const {
  const double right = 0.5 * frame_.size.width;
  const double low = 0.5 * frame_.size.height;
  double largest = 0;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(-right, -low),
                                        Eigen::Vector2d(right, -low),
                                        Eigen::Vector2d(-right, low),
                                        Eigen::Vector2d(right, low)}) {
    largest = std::max(largest, (a.Apply(camera_, corner) - b.Apply(camera_, corner)).norm());
  }
  return largest;
}

// The selection needs only an approximate common area.
std::vector<int> PlaneMeasurement::Select(const PlaneMotion& motion, int count) const {
  ImageMotion rough;
  const Eigen::Vector2d centre = motion.Apply(camera_, Eigen::Vector2d::Zero());
  rough.tx_px = centre.x();
  rough.ty_px = centre.y();
  rough.theta_rad = -motion.yaw;
  return blocks_.Select(images_.reference, images_.current, rough, count);
}

PlaneFit PlaneMeasurement::Fit(const PlaneMotion& start,
                               const PlaneFitParams& params,
                               int rounds,
                               int count) {
  PlaneFit fit;
  fit.motion = start;
  std::vector<PlaneShift> shifts;
  std::vector<PlaneShift> measured;
  std::vector<int> valid;  // blocks of `shifts` that need not be measured again
  for (int round = 0; round < rounds; ++round) {
    const int wanted = round == 0 ? kFirstPlaneBlocks : count;
    std::vector<int> chosen = Select(fit.motion, wanted);
    if (valid.empty()) shifts.clear();
    std::erase_if(chosen, [&valid](int block) {
      return std::find(valid.begin(), valid.end(), block) != valid.end();
    });
    const int search_px = round == 0 ? kFarPx : kNearPx;
    blocks_.MeasurePlane(
        images_.reference, images_.current, camera_, fit.motion, chosen, search_px, measured);
    shifts.insert(shifts.end(), measured.begin(), measured.end());
    const PlaneMotion from = fit.motion;
    const bool prepares = round == 0 && rounds > 1;
    fit = FitPlaneMotion(camera_, shifts, from, params, !prepares);
    if (!fit.ok) return fit;
    // A block measured again from less than this distance would give the same shift.
    constexpr double kSettledPx = 0.3;
    const bool settled = CornerStep(from, fit.motion) < kSettledPx;
    if (round > 0 && settled) break;
    valid.clear();
    if (settled) valid = std::move(chosen);
  }
  fit.sigma_px *= frame_.factor;
  return fit;
}

std::vector<PlaneShift> PlaneMeasurement::Measure(const PlaneMotion& motion, int count) {
  const auto chosen = Select(motion, count);
  std::vector<PlaneShift> shifts;
  blocks_.MeasurePlane(
      images_.reference, images_.current, camera_, motion, chosen, kNearPx, shifts);
  for (PlaneShift& shift : shifts) {
    shift.block.point = frame_.factor * shift.block.point + frame_.offset;
    shift.block.shift *= frame_.factor;
    shift.seen = frame_.factor * shift.seen + frame_.offset;
  }
  return shifts;
}

}  // namespace ceilmap::registration
