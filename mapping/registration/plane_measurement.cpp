#include "mapping/registration/plane_measurement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace ceilmap::registration {
namespace {

constexpr int kFirstPlaneBlocks = 24;
// Distances within which the peak of a block is searched, pixels of the level: from the start, and
// from a motion that was fitted.
constexpr int kFarPx = 8;
constexpr int kNearPx = 4;

/// Whether the tilt is zero within its standard deviations, and these are small.
bool IsSurelyLevel(const PlaneFit& fit) {
  constexpr double kSigmas = 3;
  constexpr double kMaxSigmaRad = 7e-4;  // 0.04 degrees
  const Eigen::Vector2d tilt(fit.motion.tilt_x, fit.motion.tilt_y);
  return fit.tilt_spread.diagonal().maxCoeff() < kMaxSigmaRad * kMaxSigmaRad &&
         tilt.dot(fit.tilt_spread.inverse() * tilt) < kSigmas * kSigmas;
}

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

PlaneFit PlaneMeasurement::Approach(const PlaneMotion& start, const PlaneFitParams& params) {
  std::vector<PlaneShift> shifts;
  blocks_.MeasurePlane(images_.reference,
                       images_.current,
                       camera_,
                       start,
                       Select(start, kFirstPlaneBlocks),
                       kFarPx,
                       shifts);
  return FitPlaneMotion(camera_, shifts, start, params);
}

/// One round. With Effort::kTracking, half of the blocks are sufficient for a level camera.
PlaneFit PlaneMeasurement::FitOnce(const PlaneMotion& from,
                                   const PlaneFitParams& params,
                                   int count,
                                   Effort effort) {
  std::vector<PlaneShift> shifts;
  const auto measure = [&](const std::vector<int>& chosen, std::vector<PlaneShift>& out) {
    blocks_.MeasurePlane(images_.reference, images_.current, camera_, from, chosen, kNearPx, out);
  };
  if (effort == Effort::kFull) {
    measure(Select(from, count), shifts);
    return FitPlaneMotion(camera_, shifts, from, params, &shared_);
  }
  const std::vector<int> first = Select(from, kFirstPlaneBlocks);
  measure(first, shifts);
  PlaneFit quick = FitPlaneMotion(camera_, shifts, from, params, &shared_);
  if (quick.ok && IsSurelyLevel(quick)) return quick;
  std::vector<PlaneShift> more;
  measure(Without(Select(from, count), first), more);
  shifts.insert(shifts.end(), more.begin(), more.end());
  return FitPlaneMotion(camera_, shifts, from, params, &shared_);
}

PlaneFit PlaneMeasurement::Fit(
    const PlaneMotion& start, const PlaneFitParams& params, int rounds, int count, Effort effort) {
  PlaneFit fit;
  fit.motion = start;
  for (int round = 0; round < rounds; ++round) {
    const PlaneMotion from = fit.motion;
    fit = FitOnce(from, params, count, effort);
    if (!fit.ok) return fit;
    // A block measured again from less than this distance would give the same shift.
    constexpr double kSettledPx = 0.3;
    if (CornerStep(from, fit.motion) < kSettledPx) break;
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
