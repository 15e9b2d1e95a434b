#include "mapping/registration/registrar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "calib/base/error.hpp"
#include "mapping/registration/buffer_pool.hpp"
#include "mapping/registration/coarse.hpp"
#include "mapping/registration/depth_search.hpp"
#include "mapping/registration/depth_stage.hpp"
#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/impulses.hpp"
#include "mapping/registration/joint_stage.hpp"
#include "mapping/registration/noise.hpp"
#include "mapping/registration/plane_search.hpp"

namespace ceilmap::registration {

namespace {

// Grey levels; images with less show nothing.
constexpr double kMinContrast = 0.25;

void CheckNotEmpty(const FrameSpectrum& reference,
                   const FrameSpectrum& current,
                   const char* function) {
  if (!reference.empty() && !current.empty()) return;
  throw std::invalid_argument(fmt::format("Registrar::{}: an empty FrameSpectrum", function));
}

}  // namespace

struct Registrar::Impl {
  Impl(cv::Size image_size, const RegistrarParams& p)
      : size(image_size), params(p), coarse(image_size, p.mask), fine(image_size, p) {}

  /// Made for the first image with depth.
  DepthStage& Depth() {
    if (!depth) depth.emplace(size, params);
    return *depth;
  }

  /// Made for the first image of weak texture.
  JointStage& Joint() {
    if (!joint) joint.emplace(size, params);
    return *joint;
  }

  using Coarse = FrameSpectrum::Coarse;
  using Fine = FrameSpectrum::Fine;
  cv::Size size;
  RegistrarParams params;
  CoarseStage coarse;
  FineStage fine;
  std::optional<DepthStage> depth;
  std::optional<JointStage> joint;
  std::shared_ptr<BufferPool<Coarse>> coarse_pool = std::make_shared<BufferPool<Coarse>>();
  std::shared_ptr<BufferPool<Fine>> fine_pool = std::make_shared<BufferPool<Fine>>();
  cv::Mat clean;

  std::shared_ptr<Coarse> AnalyzeCoarse(const cv::Mat& clean_grey,
                                        float noise,
                                        const cv::Mat& mask);
  std::shared_ptr<Fine> AnalyzeFine(const cv::Mat& clean_grey, float noise, const cv::Mat& mask);
  /// Searches the motion under a ceiling with depth.
  Registration FindWithDepth(const FrameSpectrum& reference,
                             const heights::HeightField& known,
                             const FrameSpectrum& current,
                             const std::optional<MotionPrior>& prior,
                             const std::optional<ImageMotion>& start) {
    return DepthSearch(coarse, fine, Depth(), params)
        .Find(PartsOf(reference), known, PartsOf(current), prior, start);
  }
  static ImageParts PartsOf(const FrameSpectrum& spectrum) {
    return {spectrum.coarse_.get(), *spectrum.fine_};
  }
};

std::shared_ptr<FrameSpectrum::Coarse> Registrar::Impl::AnalyzeCoarse(const cv::Mat& clean_grey,
                                                                      float noise,
                                                                      const cv::Mat& mask) {
  std::shared_ptr<Coarse> data = BufferPool<Coarse>::Take(coarse_pool);
  coarse.Analyze(clean_grey, noise, *data, mask);
  return data;
}

std::shared_ptr<FrameSpectrum::Fine> Registrar::Impl::AnalyzeFine(const cv::Mat& clean_grey,
                                                                  float noise,
                                                                  const cv::Mat& mask) {
  std::shared_ptr<Fine> data = BufferPool<Fine>::Take(fine_pool);
  data->rough_ready = false;
  data->fine_ready = false;
  data->small_ready = false;
  data->broad_ready = false;
  data->features_ready = false;
  fine.Analyze(clean_grey, noise, *data, mask);
  return data;
}

Registrar::Registrar(cv::Size size, const RegistrarParams& params) {
  constexpr int kSmallest = 96;
  constexpr int kLargest = 16384;
  if (std::min(size.width, size.height) < kSmallest ||
      std::max(size.width, size.height) > kLargest) {
    throw InputError(
        fmt::format("images of {}x{} cannot be registered; each side must have {} to {} pixels",
                    size.width,
                    size.height,
                    kSmallest,
                    kLargest));
  }
  if (!params.mask.empty() && (params.mask.type() != CV_8UC1 || params.mask.size() != size)) {
    throw InputError("the mask of a registrar must be an 8-bit image of its images' size");
  }
  impl_ = std::make_unique<Impl>(size, params);
}
Registrar::~Registrar() = default;
Registrar::Registrar(Registrar&&) noexcept = default;
Registrar& Registrar::operator=(Registrar&&) noexcept = default;

void Registrar::Check(const cv::Mat& grey, const cv::Mat& mask) const {
  if (grey.type() != CV_8UC1 || grey.size() != impl_->size) {
    throw InputError(fmt::format("image of {}x{} where {}x{} grey is expected",
                                 grey.cols,
                                 grey.rows,
                                 impl_->size.width,
                                 impl_->size.height));
  }
  if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != impl_->size)) {
    throw InputError("an image's mask must be an 8-bit image of its size");
  }
}

double FrameSpectrum::CodingLoss() const {
  return fine_ ? fine_->noise.removed : 0;
}

FrameSpectrum Registrar::Analyze(const cv::Mat& grey, const cv::Mat& mask) {
  return Complete(grey, {}, mask);
}

FrameSpectrum Registrar::AnalyzeFine(const cv::Mat& grey, const cv::Mat& mask) {
  Check(grey, mask);
  FrameSpectrum spectrum;
  const cv::Mat& clean = WithoutImpulses(grey, impl_->clean);
  spectrum.fine_ = impl_->AnalyzeFine(clean, EstimateNoise(clean), mask);
  spectrum.fine_->impulses = clean.data != grey.data;
  return spectrum;
}

FrameSpectrum Registrar::Complete(const cv::Mat& grey,
                                  const FrameSpectrum& spectrum,
                                  const cv::Mat& mask) {
  if (spectrum.HasCoarse()) return spectrum;
  FrameSpectrum complete = spectrum.empty() ? AnalyzeFine(grey, mask) : spectrum;
  Check(grey, mask);
  const FrameSpectrum::Fine& fine = *complete.fine_;
  const cv::Mat& clean = fine.impulses ? WithoutImpulses(grey, impl_->clean) : grey;
  complete.coarse_ = impl_->AnalyzeCoarse(clean, fine.noise.white, mask);
  return complete;
}

Registration Registrar::RegisterWithDepth(const FrameSpectrum& reference,
                                          const FrameSpectrum& current,
                                          const std::optional<MotionPrior>& prior,
                                          const std::optional<ImageMotion>& start) {
  return impl_->FindWithDepth(reference, impl_->Depth().Unknown(), current, prior, start);
}

Registration Registrar::RegisterJointly(const FrameSpectrum& reference,
                                        const FrameSpectrum& current,
                                        const MotionPrior& prior) {
  CheckNotEmpty(reference, current, "RegisterJointly");
  JointStage& joint = impl_->Joint();
  joint.Prepare(*reference.fine_);
  joint.Prepare(*current.fine_);
  return joint.Match({*reference.fine_, *current.fine_, reference.Heights()}, prior);
}

Registration Registrar::CorrectJointly(const FrameSpectrum& reference,
                                       const FrameSpectrum& current,
                                       const ImageMotion& expected,
                                       const Eigen::Matrix3d& covariance) {
  CheckNotEmpty(reference, current, "CorrectJointly");
  JointStage& joint = impl_->Joint();
  joint.Prepare(*reference.fine_);
  joint.Prepare(*current.fine_);
  return joint.Posterior(
      {*reference.fine_, *current.fine_, reference.Heights()}, expected, covariance);
}

PlaneFit Registrar::RefineWithDepth(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const PlaneMotion& start) {
  impl_->fine.PrepareReference(*reference.fine_);
  impl_->Depth().PrepareReference(*reference.fine_);
  return impl_->depth->MatchTilted(
      *reference.fine_, impl_->Depth().OnGrid(*reference.heights_), *current.fine_, start);
}

const heights::HeightField& Registrar::EmptyHeights() const {
  return impl_->Depth().Unknown();
}

heights::HeightField Registrar::PredictHeights(const FrameSpectrum& reference,
                                               const ImageMotion& motion) const {
  return impl_->Depth().Predicted(*reference.heights_, motion);
}

heights::HeightField Registrar::RefineHeights(const FrameSpectrum& reference,
                                              const FrameSpectrum& other,
                                              const ImageMotion& motion) {
  impl_->fine.PrepareReference(*reference.fine_);
  impl_->Depth().PrepareReference(*reference.fine_);
  return impl_->Depth().Refined(
      *reference.fine_, impl_->Depth().OnGrid(*reference.heights_), *other.fine_, motion);
}

Registration Registrar::Register(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const std::optional<MotionPrior>& prior) {
  CheckNotEmpty(reference, current, "Register");
  if (!reference.HasCoarse() || !current.HasCoarse()) {
    throw std::invalid_argument("Registrar::Register: a FrameSpectrum of AnalyzeFine");
  }
  if (std::min(reference.coarse_->contrast, current.coarse_->contrast) < kMinContrast) {
    Registration none;
    none.verdict = Verdict::kNoTexture;
    return none;
  }
  if (reference.heights_) {
    return impl_->FindWithDepth(reference, *reference.heights_, current, prior, std::nullopt);
  }
  return PlaneSearch(impl_->coarse, impl_->fine, impl_->params, impl_->size)
      .Find(Impl::PartsOf(reference), Impl::PartsOf(current), prior);
}

PlaneFit Registrar::RefinePlane(const FrameSpectrum& reference,
                                const FrameSpectrum& current,
                                const PlaneCamera& camera,
                                const PlaneMotion& start,
                                const PlaneFitParams& params) {
  CheckNotEmpty(reference, current, "RefinePlane");
  constexpr int kRounds = 3;
  impl_->fine.PrepareFine(*reference.fine_);
  return impl_->fine.RefinePlane(*reference.fine_, *current.fine_, camera, start, params, kRounds);
}

std::vector<PlaneShift> Registrar::MeasurePlane(const FrameSpectrum& reference,
                                                const FrameSpectrum& current,
                                                const PlaneCamera& camera,
                                                const PlaneMotion& motion) {
  CheckNotEmpty(reference, current, "MeasurePlane");
  impl_->fine.PrepareFine(*reference.fine_);
  return impl_->fine.MeasurePlane(
      *reference.fine_, *current.fine_, camera, motion, impl_->params.final_blocks);
}

std::vector<PlaneShift> Registrar::MeasureWithDepth(const FrameSpectrum& reference,
                                                    const FrameSpectrum& current,
                                                    const PlaneMotion& motion,
                                                    int count) {
  CheckNotEmpty(reference, current, "MeasureWithDepth");
  impl_->fine.PrepareFine(*reference.fine_);
  DepthStage& depth = impl_->Depth();
  depth.PrepareReference(*reference.fine_);
  return depth.Measure(
      *reference.fine_, depth.OnGrid(*reference.heights_), *current.fine_, motion, count);
}

Dissimilarity Registrar::Compare(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const ImageMotion& motion) {
  CheckNotEmpty(reference, current, "Compare");
  return impl_->fine.Compare(*reference.fine_, *current.fine_, motion);
}

double Registrar::TexturedRatio(const FrameSpectrum& spectrum) {
  CheckNotEmpty(spectrum, spectrum, "TexturedRatio");
  return impl_->fine.TexturedRatio(*spectrum.fine_);
}

double Registrar::TellingRatio(const FrameSpectrum& reference,
                               const FrameSpectrum& current,
                               const ImageMotion& motion) {
  CheckNotEmpty(reference, current, "TellingRatio");
  return impl_->fine.TellingRatio(*reference.fine_, *current.fine_, motion);
}

Registration Registrar::Refine(const FrameSpectrum& reference,
                               const FrameSpectrum& current,
                               const ImageMotion& start) {
  CheckNotEmpty(reference, current, "Refine");
  FrameSpectrum::Fine& ref = *reference.fine_;
  const FrameSpectrum::Fine& cur = *current.fine_;
  impl_->fine.PrepareReference(ref);
  Hypothesis hypothesis;
  hypothesis.motion = start;
  hypothesis.overlap = OverlapOf(start, impl_->size);
  hypothesis.peak = impl_->params.refine_poc_peak;
  const Finalist finalist = impl_->fine.Refine(ref, cur, impl_->fine.Test(ref, cur, hypothesis));
  Registration result = finalist.result;
  result.peak = finalist.agreement;
  return result;
}

}  // namespace ceilmap::registration
