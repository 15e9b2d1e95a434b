#include "mapping/registration/registrar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "calib/base/error.hpp"
#include "mapping/registration/aliasing_check.hpp"
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

  /// Made for the first match without a prediction.
  AliasingCheck& Aliasing() {
    if (!aliasing) aliasing.emplace(size, params);
    return *aliasing;
  }

  using Data = FrameSpectrum::Data;
  cv::Size size;
  RegistrarParams params;
  CoarseStage coarse;
  FineStage fine;
  std::optional<DepthStage> depth;
  std::optional<JointStage> joint;
  std::optional<AliasingCheck> aliasing;
  std::shared_ptr<BufferPool<Data>> pool = std::make_shared<BufferPool<Data>>();
  cv::Mat clean;

  std::shared_ptr<Data> Analyze(const cv::Mat& grey, const cv::Mat& mask, const Encoding& encoding);
  /// Searches the motion under a ceiling with depth.
  Registration FindWithDepth(const FrameSpectrum& reference,
                             const heights::HeightField& known,
                             const FrameSpectrum& current,
                             const std::optional<MotionPrior>& prior,
                             const std::optional<ImageMotion>& start) {
    return DepthSearch(coarse, fine, Depth(), params)
        .Find(*reference.data_, known, *current.data_, prior, start);
  }
};

std::shared_ptr<FrameSpectrum::Data> Registrar::Impl::Analyze(const cv::Mat& grey,
                                                              const cv::Mat& mask,
                                                              const Encoding& encoding) {
  std::shared_ptr<Data> data = BufferPool<Data>::Take(pool);
  data->coarse_ready = false;
  data->contrast_ready = false;
  data->unique.reset();
  data->rough_ready = false;
  data->fine_ready = false;
  data->small_ready = false;
  data->broad_ready = false;
  data->features_ready = false;
  const cv::Mat& without_impulses = WithoutImpulses(grey, clean);
  const float white = EstimateNoise(without_impulses);
  // So that the loss comes out again.
  const double sensor =
      encoding.loss ? white / std::max(1e-3, 1 - *encoding.loss) : double{kSensorNoise};
  data->noise = MakeNoise(white, static_cast<float>(sensor));
  if (encoding.loss_as_taken) {
    data->noise.removed_as_taken = static_cast<float>(*encoding.loss_as_taken);
  }
  data->noise.predicted = encoding.predicted;
  data->pixel_rate_bit_s = encoding.pixel_rate_bit_s;
  coarse.Reduce(without_impulses, mask, data->working);
  fine.Analyze(without_impulses, mask, *data);
  return data;
}

void SetForView(const calib::CeilingView& view, RegistrarParams& params) {
  params.mask = view.Mask();
  params.camera = PlaneCameraOf(view);
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
  return data_ ? data_->noise.removed_as_taken : 0;
}

double FrameSpectrum::SmoothingLoss() const {
  return data_ ? data_->noise.removed : 0;
}

void FrameSpectrum::ReleaseBlocks() {
  if (!data_ || data_.use_count() != 1) return;
  std::atomic_thread_fence(std::memory_order_acquire);  // after the last use by another owner
  data_->ReleaseBlocks();
  data_->coarse = Coarse();
  data_->coarse_ready = false;
  data_->contrast_ready = false;
}

bool FrameSpectrum::IsBlurredBeside(double sharp_loss) const {
  constexpr double kBlurred = 0.2;
  return CodingLoss() > sharp_loss + kBlurred;
}

bool FrameSpectrum::IsDistorted() const {
  constexpr double kDistortingLoss = 0.35;
  return CodingLoss() >= kDistortingLoss;
}

bool FrameSpectrum::IsStarved() const {
  // Bits per second and pixel. Weak plaster encoded by x265: with 0.038 to 0.07 (CRF 35) no place
  // was wrong; with 0.028 to 0.04 (CRF 40) and 0.019 to 0.028 (CRF 45) each tenth one was.
  constexpr double kStarvedRate = 0.036;
  const double rate = data_ ? data_->pixel_rate_bit_s : 0;
  return rate > 0 && rate < kStarvedRate && IsDistorted();
}

Encoding FrameSpectrum::GetEncoding() const {
  if (!data_) return {};
  return {data_->noise.predicted,
          data_->pixel_rate_bit_s,
          data_->noise.removed,
          data_->noise.removed_as_taken};
}

FrameSpectrum Registrar::Analyze(const cv::Mat& grey,
                                 const cv::Mat& mask,
                                 const Encoding& encoding) {
  Check(grey, mask);
  FrameSpectrum spectrum;
  spectrum.data_ = impl_->Analyze(grey, mask, encoding);
  return spectrum;
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
  joint.Prepare(*reference.data_);
  joint.Prepare(*current.data_);
  return joint.Match({*reference.data_, *current.data_, reference.Heights()}, prior);
}

Registration Registrar::CorrectJointly(const FrameSpectrum& reference,
                                       const FrameSpectrum& current,
                                       const ImageMotion& expected,
                                       const Eigen::Matrix3d& covariance) {
  CheckNotEmpty(reference, current, "CorrectJointly");
  JointStage& joint = impl_->Joint();
  joint.Prepare(*reference.data_);
  joint.Prepare(*current.data_);
  return joint.Posterior(
      {*reference.data_, *current.data_, reference.Heights()}, expected, covariance);
}

PlaneFit Registrar::RefineWithDepth(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const PlaneMotion& start) {
  impl_->fine.PrepareRough(*reference.data_);
  impl_->Depth().PrepareReference(*reference.data_);
  return impl_->depth->MatchTilted(
      *reference.data_, impl_->Depth().OnGrid(*reference.heights_), *current.data_, start);
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
  impl_->Depth().PrepareReference(*reference.data_);
  return impl_->Depth().Refined(
      *reference.data_, impl_->Depth().OnGrid(*reference.heights_), *other.data_, motion);
}

Registration Registrar::Register(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const std::optional<MotionPrior>& prior,
                                 Effort effort) {
  CheckNotEmpty(reference, current, "Register");
  FrameSpectrum::Data& ref = *reference.data_;
  FrameSpectrum::Data& cur = *current.data_;
  PlaneSearch search(impl_->coarse, impl_->fine, impl_->params, impl_->size);
  if (prior && !reference.heights_) {
    Registration near = search.FindNear(ref, cur, *prior, effort);
    if (near.ok()) return near;
  }
  // Near an expected motion, depth needs no spectra; the search for one plane always does.
  const auto shows_texture = [&](FrameSpectrum::Data& image) {
    return reference.heights_ ? impl_->coarse.ShowsTexture(image)
                              : impl_->coarse.Of(image).ShowsTexture();
  };
  if (!shows_texture(ref) || !shows_texture(cur)) {
    Registration none;
    none.verdict = Verdict::kNoTexture;
    return none;
  }
  if (reference.heights_) {
    return impl_->FindWithDepth(reference, *reference.heights_, current, prior, std::nullopt);
  }
  return search.Find(ref, cur, prior);
}

Registration Registrar::RegisterAnyPlaces(const FrameSpectrum& reference,
                                          const FrameSpectrum& current) {
  Registration found = Register(reference, current);
  if (found.ok() &&
      !impl_->Aliasing().Distinguishes(*reference.data_, *current.data_, found.motion)) {
    found.verdict = Verdict::kAmbiguous;
  }
  return found;
}

PlaneFit Registrar::RefinePlane(const FrameSpectrum& reference,
                                const FrameSpectrum& current,
                                const PlaneCamera& camera,
                                const PlaneMotion& start,
                                const PlaneFitParams& params,
                                Effort effort) {
  CheckNotEmpty(reference, current, "RefinePlane");
  constexpr int kRounds = 2;
  impl_->fine.PrepareReference(*reference.data_);
  return impl_->fine.RefinePlane(
      *reference.data_, *current.data_, camera, start, params, kRounds, effort);
}

std::vector<PlaneShift> Registrar::MeasurePlane(const FrameSpectrum& reference,
                                                const FrameSpectrum& current,
                                                const PlaneCamera& camera,
                                                const PlaneMotion& motion) {
  CheckNotEmpty(reference, current, "MeasurePlane");
  impl_->fine.PrepareFine(*reference.data_);
  return impl_->fine.MeasurePlane(
      *reference.data_, *current.data_, camera, motion, impl_->params.final_blocks);
}

std::vector<PlaneShift> Registrar::MeasureWithDepth(const FrameSpectrum& reference,
                                                    const FrameSpectrum& current,
                                                    const PlaneMotion& motion,
                                                    int count) {
  CheckNotEmpty(reference, current, "MeasureWithDepth");
  DepthStage& depth = impl_->Depth();
  depth.PrepareReference(*reference.data_);
  return depth.Measure(
      *reference.data_, depth.OnGrid(*reference.heights_), *current.data_, motion, count);
}

Dissimilarity Registrar::Compare(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const ImageMotion& motion) {
  CheckNotEmpty(reference, current, "Compare");
  return impl_->fine.Compare(*reference.data_, *current.data_, motion);
}

bool Registrar::IsHiddenByBlur(const FrameSpectrum& reference,
                               const FrameSpectrum& current,
                               const ImageMotion& motion) {
  // Motions that were off by up to 2.2 px left a dissimilarity of 1.87, by 10 px 2.6.
  constexpr double kMaxUnexplained = 1.9;  // nats
  return Compare(reference, current, motion).mean > kMaxUnexplained;
}

double Registrar::TexturedRatio(const FrameSpectrum& spectrum) {
  CheckNotEmpty(spectrum, spectrum, "TexturedRatio");
  return impl_->fine.TexturedRatio(*spectrum.data_);
}

double Registrar::TellingRatio(const FrameSpectrum& reference,
                               const FrameSpectrum& current,
                               const ImageMotion& motion) {
  CheckNotEmpty(reference, current, "TellingRatio");
  return impl_->fine.TellingRatio(*reference.data_, *current.data_, motion);
}

Registration Registrar::Refine(const FrameSpectrum& reference,
                               const FrameSpectrum& current,
                               const ImageMotion& start) {
  CheckNotEmpty(reference, current, "Refine");
  FrameSpectrum::Data& ref = *reference.data_;
  const FrameSpectrum::Data& cur = *current.data_;
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
