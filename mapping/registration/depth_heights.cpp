// Heights of blocks: measured, kept, and brought to the scale of the reference plane.

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/registration/depth_stage.hpp"

namespace ceilmap::registration {
namespace {

// Smallest standard deviation of an inverse height ratio: what a block is does not change, but
// matching has errors that remain.
constexpr float kRhoFloor = 0.0025F;
// The same in pixels of one measurement.
constexpr double kMatchFloorPx = 0.12;
// Standard deviation of the scale of a field of heights: which part of the deck is the plane whose
// height the rig states.
constexpr double kScaleSigma = 0.01;
// Error of the reference plane's displacement where only one image shows which surface it is.
constexpr double kScaleErrorPx = 0.4;

// Inverse height ratios between which unknown heights are swept, ...
constexpr double kFarthest = 0.85;
constexpr double kNearest = 1.6;
// ... and the travel from which on they are, fine px.
constexpr double kMinSweptTravelPx = 24;

// From this displacement of the reference plane on, pixels, the heights show which surface it is.
constexpr double kMinTravelPx = 5;

}  // namespace

/// Whether blocks may be further from where an unknown height puts them than they are searched.
bool DepthStage::IsFar(const PlaneMotion& motion) const {
  return motion.TravelPx(fine_camera_) > kMinSweptTravelPx;
}

/// Whether all blocks are swept, because nothing is known of the heights.
bool DepthStage::IsSwept(const heights::HeightField& known, const PlaneMotion& motion) const {
  const bool any = std::any_of(known.cells.begin(), known.cells.end(), [](const auto& cell) {
    return cell.sigma < heights::kMeasuredSigma;
  });
  return !any && IsFar(motion);
}

/// Measures blocks of which no height is known, anywhere along the line of travel: where the images
/// are far apart, what hangs below the ceiling has moved further than a block is searched. Each is
/// taken where it agrees best.
void DepthStage::Sweep(const FrameSpectrum::Data& reference,
                       const FrameSpectrum::Data& current,
                       const PlaneMotion& motion,
                       const std::vector<int>& chosen,
                       std::vector<PlaneShift>& shifts) {
  const double step = (2 * kSmallSearch - 1) / motion.TravelPx(fine_camera_);
  std::vector<PlaneShift> best(static_cast<std::size_t>(small_.GridSize()));
  const int steps = static_cast<int>(std::ceil((kNearest - kFarthest) / step));
  for (int i = 0; i <= steps; ++i) {
    const std::vector<double> all(chosen.size(), kFarthest + i * step);
    small_.MeasurePlane(
        reference.fine, current.fine, fine_camera_, motion, chosen, kSmallSearch, shifts, all);
    for (const PlaneShift& shift : shifts) {
      PlaneShift& kept = best[static_cast<std::size_t>(shift.index)];
      if (kept.index < 0 || shift.block.peak > kept.block.peak) kept = shift;
    }
  }
  shifts.clear();
  for (const int block : chosen) {
    const PlaneShift& kept = best[static_cast<std::size_t>(block)];
    if (kept.index >= 0) shifts.push_back(kept);
  }
}

/// As MeasureSmall, and blocks whose height is not known wherever they agree best.
void DepthStage::MeasureAnyHeight(const FrameSpectrum::Data& reference,
                                  const heights::HeightField& known,
                                  const FrameSpectrum::Data& other,
                                  const PlaneMotion& motion,
                                  const std::vector<int>& chosen,
                                  std::vector<PlaneShift>& shifts) {
  std::vector<int> measured = chosen;
  std::vector<int> unmeasured;
  if (IsFar(motion)) {
    const auto first = std::stable_partition(measured.begin(), measured.end(), [&](int block) {
      return known.cells[static_cast<std::size_t>(block)].sigma < heights::kMeasuredSigma;
    });
    unmeasured.assign(first, measured.end());
    measured.erase(first, measured.end());
  }
  MeasureSmall(reference, known, other, motion, measured, shifts);
  if (unmeasured.empty()) return;
  std::vector<PlaneShift> swept;
  Sweep(reference, other, motion, unmeasured, swept);
  SetPriors(known, swept);
  shifts.insert(shifts.end(), swept.begin(), swept.end());
}

void DepthStage::Absorb(const DepthFit& fit,
                        const std::vector<PlaneShift>& shifts,
                        heights::HeightField& field) const {
  const double travel = fit.motion.TravelPx(fine_camera_);
  if (travel < 1) return;
  const auto floor = static_cast<float>(std::hypot(kRhoFloor, kMatchFloorPx / travel));
  // A block that does not agree was measured at a wrong place before, another surface of it
  // matched, or something moved. Images that are far apart show the first: a wrong height is off by
  // many pixels there, and is soon measured anew.
  const float forget = IsFar(fit.motion) ? 3.0F : 1.3F;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    heights::HeightCell& cell = field.cells[static_cast<std::size_t>(shifts[i].index)];
    const BlockHeight& seen = fit.blocks[i];
    // A block without texture may have any number: nothing is behind the camera.
    if (seen.inlier && seen.rho > 0) {
      // No more certain than one measurement of this travel can be.
      if (seen.sigma >= cell.sigma) continue;
      cell.rho = static_cast<float>(seen.rho);
      cell.sigma = std::max(static_cast<float>(seen.sigma), std::min(cell.sigma, floor));
    } else {
      cell.sigma = std::min(heights::kUnknown.sigma, forget * std::max(cell.sigma, floor));
    }
  }
}

/// Where the scale of the heights is not known well yet, the longer travel shows better which of
/// them belong to the reference plane. @return factor of all translations
double DepthStage::ScaleToReference(const PlaneMotion& motion, heights::HeightField& field) const {
  const double travel_px = motion.TravelPx(camera_);
  const double sigma = std::hypot(kScaleSigma, kScaleErrorPx / std::max(travel_px, 1e-3));
  constexpr double kBetter = 0.7;
  if (travel_px < kMinTravelPx || sigma > kBetter * field.scale_sigma) return 1;
  const auto rho = heights::FindReference(field.cells);
  // What the first images took for the reference plane may be another surface.
  constexpr double kSigmas = 3;
  if (!rho || std::abs(*rho - 1) > kSigmas * heights::kUnknownScale) return 1;
  field.Scale(1 / *rho);
  field.scale_sigma = sigma;
  return *rho;
}

heights::HeightField DepthStage::OnGrid(const heights::HeightField& known) const {
  if (known.grid == unknown_.grid && known.cells.size() == unknown_.cells.size()) return known;
  return heights::Predict(known, unknown_, [](const Eigen::Vector2d& x, double) { return x; });
}

heights::HeightField DepthStage::Refined(const FrameSpectrum::Data& reference,
                                         const heights::HeightField& known,
                                         const FrameSpectrum::Data& other,
                                         const ImageMotion& motion) {
  const PlaneMotion plane = PlaneMotion::FromSimilarity(camera_, motion);
  const auto chosen = small_.Select(reference.fine, other.fine, OnFine(plane), small_.GridSize());
  std::vector<PlaneShift> shifts;
  MeasureAnyHeight(reference, known, other, plane, chosen, shifts);
  DepthFitParams params;
  params.start_sigma_px = 0.6;
  params.fit_motion = false;
  const DepthFit fit = FitDepthMotion(fine_camera_, shifts, plane, params);
  heights::HeightField field = known;
  if (fit.ok) Absorb(fit, shifts, field);
  return field;
}

heights::HeightField DepthStage::Predicted(const heights::HeightField& known,
                                           const ImageMotion& motion) const {
  const PlaneMotion plane = PlaneMotion::FromSimilarity(camera_, motion);
  return heights::Predict(known, unknown_, [&](const Eigen::Vector2d& x, double rho) {
    return plane.Apply(camera_, x, rho);
  });
}

}  // namespace ceilmap::registration
