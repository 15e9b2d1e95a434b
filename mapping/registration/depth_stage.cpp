#include "mapping/registration/depth_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace ceilmap::registration {
namespace {

constexpr int kSmallBlockPx = 32;
constexpr int kSmallBlocks = 300;
constexpr int kMeasured = 300;  // blocks of a round
// Blocks of the first round, which only brings the second one near, where most heights are known.
constexpr int kFirstMeasured = 120;
constexpr int kRoughBlocks = 48;
constexpr int kRoughSearch = 8;  // rough pixels

// A rough block shows a larger area, seldom of one height.
constexpr float kRoughRhoSigma = 0.04F;
constexpr double kNotKnown = 2;

// Acceptance.
constexpr int kMinMatchInliers = 12;
constexpr double kMinMatchInlierRatio = 0.35;
constexpr double kMinMatchSupport = 4.2;
// Mean evidence of a block. Simulated plants: at other places up to 0.073, at the true ones 0.082
// and more (median 0.16).
constexpr double kMinMatchPeak = 0.08;
constexpr double kMaxMatchSigmaPx = 0.5;

// Residual of a block with full texture by the noise of the images, px; what exceeds it is mostly
// shared by many blocks (README.md, "Covariance", "Depth").
constexpr double kNoiseResidualPx = 0.1;
// Variance of shared errors in units of that of independent blocks, where the residuals show little
// else.
constexpr double kSharedErrors = 4;

PlaneCamera CameraOf(cv::Size size, const RegistrarParams& params) {
  PlaneCamera camera = params.camera;
  // Without tilts the focal length has no effect.
  if (camera.focal_px <= 0) camera.focal_px = std::max(size.width, size.height);
  return camera;
}

bool IsMostlyMeasured(const heights::HeightField& field) {
  const auto measured = std::count_if(field.cells.begin(), field.cells.end(), [](const auto& cell) {
    return cell.sigma < heights::kMeasuredSigma;
  });
  return 2 * measured > static_cast<std::ptrdiff_t>(field.cells.size());
}

/// Covariance of a motion with the errors that blocks share.
Eigen::Matrix<double, 6, 6> WithSharedErrors(const DepthFit& fit) {
  const double noise = std::min(1.0, kNoiseResidualPx / fit.sigma_px);
  return (1 + kSharedErrors * (1 - noise * noise)) * fit.spread;
}

}  // namespace

DepthStage::DepthStage(cv::Size size, const RegistrarParams& params)
    : params_(params),
      fine_frame_(size, FineFactor(size)),
      rough_frame_(fine_frame_.size, 2),
      camera_(CameraOf(size, params)),
      fine_camera_(fine_frame_.CameraOf(camera_)),
      rough_camera_(rough_frame_.CameraOf(fine_camera_)),
      rough_(rough_frame_.size,
             LevelMask(params.mask, rough_frame_.size),
             {kRoughBlockPx},
             params.same_recording),
      small_(fine_frame_.size,
             LevelMask(params.mask, fine_frame_.size),
             {kSmallBlockPx, kSmallBlocks, &Level::small_blocks, false},
             params.same_recording) {
  unknown_.grid = small_.Grid();
  const int cells = small_.GridSize();
  if (cells == 0) return;
  const Eigen::Vector2d first = small_.Centre(0);
  const Eigen::Vector2d last = small_.Centre(cells - 1);
  const Eigen::Vector2d steps(std::max(1, unknown_.grid.width - 1),
                              std::max(1, unknown_.grid.height - 1));
  unknown_.first_px = fine_frame_.factor * first + fine_frame_.offset;
  unknown_.step_px = fine_frame_.factor * (last - first).cwiseQuotient(steps);
  unknown_.cells.assign(static_cast<std::size_t>(cells), heights::kUnknown);
}

void DepthStage::PrepareReference(FrameSpectrum::Data& data) {
  const std::scoped_lock lock(data.mutex);
  if (data.small_ready) return;
  small_.PrepareReference(data.fine);
  data.small_ready = true;
}

ImageMotion DepthStage::OnFine(const PlaneMotion& motion) const {
  return motion.ToSimilarity(fine_camera_);
}

DepthFit DepthStage::FitRough(const FrameSpectrum::Data& reference,
                              const heights::HeightField& known,
                              const FrameSpectrum::Data& current,
                              const PlaneMotion& start,
                              bool fit_tilt) {
  const auto chosen = rough_.Select(
      reference.rough, current.rough, start.ToSimilarity(rough_camera_), kRoughBlocks);
  std::vector<double> rho;
  std::vector<float> sigma;
  for (const int block : chosen) {
    const Eigen::Vector2d at = 2 * rough_.Centre(block) + rough_frame_.offset;
    const heights::HeightCell cell = known.Around(fine_frame_.factor * at + fine_frame_.offset);
    rho.push_back(cell.rho);
    sigma.push_back(std::hypot(cell.sigma, kRoughRhoSigma));
  }
  std::vector<PlaneShift> shifts;
  rough_.MeasurePlane(
      reference.rough, current.rough, rough_camera_, start, chosen, kRoughSearch, shifts, rho);
  for (PlaneShift& shift : shifts) {
    const auto at = std::find(chosen.begin(), chosen.end(), shift.index) - chosen.begin();
    shift.rho_sigma = sigma[static_cast<std::size_t>(at)];
  }
  DepthFitParams fit;
  fit.start_sigma_px = 2;
  fit.fit_tilt = fit_tilt;
  return FitDepthMotion(rough_camera_, shifts, start, fit);
}

/// Measures blocks where `known` predicts them, with its heights as the priors of a fit.
void DepthStage::MeasureSmall(const FrameSpectrum::Data& reference,
                              const heights::HeightField& known,
                              const FrameSpectrum::Data& current,
                              const PlaneMotion& motion,
                              const std::vector<int>& chosen,
                              std::vector<PlaneShift>& shifts,
                              int passes) {
  std::vector<double> rho;
  rho.reserve(chosen.size());
  for (const int block : chosen) rho.push_back(known.cells[static_cast<std::size_t>(block)].rho);
  small_.MeasurePlane(reference.fine,
                      current.fine,
                      fine_camera_,
                      motion,
                      chosen,
                      kSmallSearch,
                      shifts,
                      rho,
                      passes);
  for (PlaneShift& shift : shifts) {
    shift.rho_sigma = known.cells[static_cast<std::size_t>(shift.index)].sigma;
  }
}

/// Blocks are sampled where the last round found them, and judged by what was known before.
void DepthStage::SetPriors(const heights::HeightField& known, std::vector<PlaneShift>& shifts) {
  const auto cell_of = [&known](const PlaneShift& shift) {
    return known.cells[static_cast<std::size_t>(shift.index)];
  };
  const auto measured = std::count_if(shifts.begin(), shifts.end(), [&](const PlaneShift& shift) {
    return cell_of(shift).sigma < heights::kMeasuredSigma;
  });
  for (PlaneShift& shift : shifts) {
    const heights::HeightCell cell = cell_of(shift);
    shift.rho = cell.rho;
    shift.rho_sigma = cell.sigma;
    // Many cells with the same assumption are not many measurements: where others are measured,
    // these say nothing of the length of the travel.
    constexpr int kEnough = 20;
    if (measured > kEnough && cell.sigma > heights::kMeasuredSigma) shift.rho_sigma = kNotKnown;
  }
}

Eigen::Matrix4d DepthStage::OfImage(const PlaneMotion& motion,
                                    const Eigen::Matrix<double, 6, 6>& covariance) const {
  const auto image = [this](const PlaneMotion& at) {
    const ImageMotion m = at.ToSimilarity(camera_);
    return Eigen::Vector3d(m.tx_px, m.ty_px, m.theta_rad);
  };
  const Eigen::Vector3d at = image(motion);
  constexpr double kStep = 1e-6;
  Eigen::Matrix3d jacobian;
  for (int i = 0; i < 3; ++i) {
    PlaneMotion moved = motion;
    (i == 0 ? moved.x : i == 1 ? moved.y : moved.yaw) += kStep;
    jacobian.col(i) = (image(moved) - at) / kStep;
  }
  constexpr std::array<int, 3> kLevel = {0, 1, 3};  // x, y, yaw
  const Eigen::Matrix3d level = covariance(kLevel, kLevel);
  Eigen::Matrix4d of_image = Eigen::Matrix4d::Zero();
  of_image.topLeftCorner<3, 3>() = jacobian * level * jacobian.transpose();
  return of_image;
}

bool DepthStage::FitSmall(const FrameSpectrum::Data& reference,
                          const heights::HeightField& known,
                          const FrameSpectrum::Data& current,
                          bool fit_tilt,
                          SmallFit& small) {
  small.field = known;
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) {
    const int count = round == 0 && IsMostlyMeasured(known) ? kFirstMeasured : kMeasured;
    const auto chosen =
        small_.Select(reference.fine, current.fine, OnFine(small.fit.motion), count);
    if (round == 0 && IsSwept(known, small.fit.motion)) {
      Sweep(reference, current, small.fit.motion, chosen, small.shifts);
    } else {
      MeasureSmall(reference, small.field, current, small.fit.motion, chosen, small.shifts);
    }
    SetPriors(known, small.shifts);
    if (!FitShifts(known, small.fit.motion, round == 0 ? 1.5 : 0.6, fit_tilt, small)) return false;
  }
  return true;
}

/// Fits the measured blocks; `small.field` takes the heights.
bool DepthStage::FitShifts(const heights::HeightField& known,
                           const PlaneMotion& start,
                           double start_sigma_px,
                           bool fit_tilt,
                           SmallFit& small) const {
  DepthFitParams params;
  params.fit_tilt = fit_tilt;
  params.start_sigma_px = start_sigma_px;
  small.fit = FitDepthMotion(fine_camera_, small.shifts, start, params);
  if (!small.fit.ok) return false;
  small.field = known;
  Absorb(small.fit, small.shifts, small.field);
  return true;
}

bool DepthStage::Fit(const FrameSpectrum::Data& reference,
                     const heights::HeightField& known,
                     const FrameSpectrum::Data& current,
                     const PlaneMotion& start,
                     bool fit_tilt,
                     SmallFit& small) {
  small.fit = FitRough(reference, known, current, start, fit_tilt);
  return small.fit.ok && small.fit.inliers >= kMinMatchInliers / 2 &&
         FitSmall(reference, known, current, fit_tilt, small);
}

bool DepthStage::EnoughAgree(const DepthFit& fit) {
  return fit.inliers >= kMinMatchInliers && fit.support > kMinMatchSupport;
}

/// Largest standard deviation of a displacement that is accepted, pixels of the full image. Where
/// no height is known, the length of the travel is only known to a part of it.
double DepthStage::MaxSigmaPx(const heights::HeightField& known, const PlaneMotion& motion) const {
  constexpr double kMaxPart = 0.025;
  const double by_image = kMaxMatchSigmaPx * std::max(1.0, fine_frame_.factor);
  return IsSwept(known, motion) ? std::hypot(by_image, kMaxPart * motion.TravelPx(camera_))
                                : by_image;
}

Registration DepthStage::Match(const FrameSpectrum::Data& reference,
                               const heights::HeightField& known,
                               const FrameSpectrum::Data& current,
                               const ImageMotion& start) {
  Registration result;
  result.motion = start;
  ImageMotion level = start;
  level.scale = 1;
  SmallFit small;
  const PlaneMotion from = PlaneMotion::FromSimilarity(camera_, level);
  if (!Fit(reference, known, current, from, false, small)) return result;
  auto& [fit, field, shifts] = small;
  const double relative = ScaleToReference(fit.motion, field);
  fit.motion.x *= relative;
  fit.motion.y *= relative;
  result.rescaled = relative;
  result.motion = fit.motion.ToSimilarity(camera_);
  result.blocks = static_cast<int>(fit.blocks.size());
  result.inliers = fit.inliers;
  result.peak = fit.support / std::max<double>(1, static_cast<double>(fit.blocks.size()));
  result.overlap = OverlapOf(OnFine(fit.motion), fine_frame_.size);
  if (fit.content > 0) result.textured_peak = fit.support / fit.content;
  result.textured_inliers = fit.TexturedInliers();
  const double sigma = std::sqrt(OfImage(fit.motion, fit.spread).diagonal().head<2>().maxCoeff());
  Eigen::Matrix<double, 6, 6> stated = WithSharedErrors(fit);
  const Eigen::Vector2d t(fit.motion.x, fit.motion.y);
  stated.topLeftCorner<2, 2>() += field.scale_sigma * field.scale_sigma * t * t.transpose();
  result.covariance = OfImage(fit.motion, stated);
  if (EnoughAgree(fit) && fit.inliers >= kMinMatchInlierRatio * result.blocks &&
      result.peak > kMinMatchPeak && sigma < MaxSigmaPx(known, fit.motion)) {
    result.verdict = Verdict::kOk;
    result.heights = std::make_shared<const heights::HeightField>(std::move(field));
  }
  return result;
}

std::vector<PlaneShift> DepthStage::Measure(const FrameSpectrum::Data& reference,
                                            const heights::HeightField& known,
                                            const FrameSpectrum::Data& current,
                                            const PlaneMotion& motion,
                                            int count) {
  auto chosen = small_.Select(reference.fine, current.fine, OnFine(motion), count);
  std::erase_if(chosen, [&known](int block) {
    return known.cells[static_cast<std::size_t>(block)].sigma >= heights::kMeasuredSigma;
  });
  std::vector<PlaneShift> shifts;
  constexpr int kPasses = 2;
  MeasureSmall(reference, known, current, motion, chosen, shifts, kPasses);
  for (PlaneShift& shift : shifts) {
    shift.block.point = fine_frame_.factor * shift.block.point + fine_frame_.offset;
    shift.block.shift *= fine_frame_.factor;
    shift.seen = fine_frame_.factor * shift.seen + fine_frame_.offset;
  }
  return shifts;
}

}  // namespace ceilmap::registration
