#include "localization/localizer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "calib/error.hpp"
#include "localization/frame_chain.hpp"
#include "localization/map_shape.hpp"

namespace ceilmap::localization {

using calib::Pose2;
using mapping::TrackingStatus;
using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registrar;
using registration::Registration;
using registration::Verdict;

void LocalizerParams::Validate() const {
  const auto require = [](bool good, const char* field, double value, const char* range) {
    if (good) return;
    throw calib::InputError(fmt::format("localizer: {} = {}, must be {}", field, value, range));
  };
  heading.Validate();
  motion.Validate();
  patches.Validate();
  places.Validate();
  hypotheses.Validate();
  require(min_overlap > 0 && min_overlap < 1, "min_overlap", min_overlap, "in (0, 1)");
  require(max_sigmas > 0, "max_sigmas", max_sigmas, "> 0");
  require(min_prior_sigma_px > 0, "min_prior_sigma_px", min_prior_sigma_px, "> 0");
  require(min_prior_sigma_rad > 0, "min_prior_sigma_rad", min_prior_sigma_rad, "> 0");
  require(give_up_start_after >= 1, "give_up_start_after", give_up_start_after, "at least 1");
  require(unseen_speed > 0, "unseen_speed", unseen_speed, "> 0");
  require(unseen_turn > 0, "unseen_turn", unseen_turn, "> 0");
  require(scale_frames >= 0, "scale_frames", scale_frames, "at least 0");
  require(max_scale_error > 0 && max_scale_error < 0.3,
          "max_scale_error",
          max_scale_error,
          "in (0, 0.3)");
  require(noise.systematic_px > 0, "noise.systematic_px", noise.systematic_px, "> 0");
  require(noise.systematic_rad > 0, "noise.systematic_rad", noise.systematic_rad, "> 0");
}

namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix2d c = covariance.topLeftCorner<2, 2>();
  const double mean = 0.5 * c.trace();
  const double root = std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1));
  return std::sqrt(std::max(0.0, mean + root));
}

/// The camera's view when everything that it sees is `scale` times as large as the rig says, in
/// pixels.
calib::CeilingView MakeView(const calib::MountedCamera& up, double ceiling_height_m, double scale) {
  const double camera_m = up.T_base_cam.translation().z();
  return {up, camera_m + (ceiling_height_m - camera_m) / scale};
}

calib::CeilingView MakeFirstView(const mapping::MapReader& map, const calib::MountedCamera& up) {
  const mapping::MapMetadata& metadata = map.Metadata();
  if (metadata.unit != "m") {
    throw calib::InputError(
        "the map is in pixels, because it was made without a rig; make it again with --rig");
  }
  if (map.Grid().width_px == 0) {
    throw calib::InputError("the map has no mosaic to find a robot on; make it again");
  }
  calib::CeilingView view = MakeView(up, metadata.ceiling_height_m, 1);
  constexpr double kMostScale = 6;
  const double scale = view.MetresPerPixel() / metadata.view_units_per_px;
  if (scale > kMostScale || scale < 1 / kMostScale) {
    throw calib::InputError(fmt::format(
        "the camera sees {:.2g} mm of this ceiling in a pixel, the map's camera {:.2g} mm: too "
        "different to be compared; check the rig's focal length and height",
        1e3 * view.MetresPerPixel(),
        1e3 * metadata.view_units_per_px));
  }
  return view;
}

registration::RegistrarParams WithScale(registration::RegistrarParams params,
                                        const calib::CeilingView& view,
                                        bool estimate_scale) {
  params.estimate_scale = estimate_scale;
  params.mask = view.Mask();
  return params;
}

}  // namespace

struct Localizer::Impl {
  Impl(const mapping::MapReader& map_reader,
       const calib::MountedCamera& camera,
       const LocalizerParams& p)
      : map(map_reader),
        up(camera),
        params(p),
        view(MakeFirstView(map, up)),
        registrar(view.Size(), WithScale(p.registration, view, false)),
        scaling(view.Size(), WithScale(p.registration, view, true)),
        span(std::max(view.Size().width, view.Size().height) * view.MetresPerPixel()),
        patches(std::make_unique<MapPatches>(map, view, registrar, p.patches)),
        chain(view),
        finder(map, view, p.places),
        shape(map),
        motion(p.motion),
        hypotheses(span, p.hypotheses),
        heading(p.heading),
        scale_known(p.scale_frames == 0) {
    hypotheses.Clear();
    if (params.start) hypotheses.Trust(*params.start);
  }

  const mapping::MapReader& map;
  calib::MountedCamera up;
  LocalizerParams params;
  calib::CeilingView view;
  Registrar registrar;
  Registrar scaling;  // until the scale is known
  double span;        // map units across the picture's longer side
  std::unique_ptr<MapPatches> patches;
  FrameChain chain;
  PlaceFinder finder;
  MapShape shape;
  MotionModel motion;
  Hypotheses hypotheses;
  HeadingFusion heading;
  LocalizerReport report;

  bool scale_known;
  std::vector<double> scales;
  std::shared_ptr<const Patch> patch;  // that the robot is followed on
  PoseEstimate last_pose;              // of the last placed frame, ...
  cv::Mat last_picture;                // ... rectified
  std::int64_t last_index = 0;
  std::optional<double> first_stamp_s;
  std::optional<double> last_stamp_s;  // of any frame
  double seen_stamp_s = 0;             // of the last frame that the chain could place
  bool was_placed = false;
  int frames_of_start = 0;
  int ambiguous_looks = 0;  // places of this frame within which several poses explain it

  cv::Mat rectified;

  void Check(const CeilingFrame& frame) const;
  [[nodiscard]] MotionPrior PriorFor(const Patch& at, const PoseEstimate& expected) const;
  std::optional<Look> LookAt(const Patch& at,
                             const FrameSpectrum& spectrum,
                             const std::optional<PoseEstimate>& expected,
                             double* scale = nullptr);
  void Compare(const Patch& at, const FrameSpectrum& spectrum, Look& look);
  [[nodiscard]] double Overlap(const Patch& at, const Pose2& T_map_base) const;
  void ChoosePatch(const PoseEstimate& expected);
  bool Track(const CeilingFrame& frame,
             const FrameSpectrum& spectrum,
             const std::optional<HeadingPrior>& yaw,
             Location& location);
  void MoveHypotheses(const CeilingFrame& frame, const cv::Mat& picture, bool& seen);
  [[nodiscard]] bool Wanted(const PlaceProposal& place,
                            double stamp_s,
                            const std::optional<HeadingPrior>& yaw) const;
  std::optional<Look> LookNear(const Pose2& T_map_base,
                               const FrameSpectrum& spectrum,
                               const std::optional<PoseEstimate>& expected);
  void LookElsewhere(double stamp_s,
                     const cv::Mat& picture,
                     const FrameSpectrum& spectrum,
                     const std::optional<HeadingPrior>& yaw);
  void Search(const CeilingFrame& frame,
              const cv::Mat& picture,
              const FrameSpectrum& spectrum,
              const std::optional<HeadingPrior>& yaw,
              Location& location);
  void LearnScale(double scale);
  void Place(const Look& look, Location& location);
};

void Localizer::Impl::Check(const CeilingFrame& frame) const {
  if (last_stamp_s && !(frame.stamp_s > *last_stamp_s)) {
    throw calib::InputError(
        fmt::format("frame {}: time {} s is not later than that of the frame before",
                    frame.index,
                    frame.stamp_s));
  }
  if (!std::isfinite(frame.stamp_s)) {
    throw calib::InputError(fmt::format("frame {}: its time is not finite", frame.index));
  }
  if (frame.heading && !(frame.heading->variance_rad2 > 0)) {
    throw calib::InputError(fmt::format("frame {}: a heading's variance must be > 0", frame.index));
  }
}

MotionPrior Localizer::Impl::PriorFor(const Patch& at, const PoseEstimate& expected) const {
  MotionPrior prior;
  prior.motion = mapping::ImageMotionOf(view, at.T_map_base.Inverse() * expected.T_map_base);
  prior.sigma_px = std::max(params.min_prior_sigma_px,
                            LargestSigma(expected.covariance) / view.MetresPerPixel());
  prior.sigma_theta_rad =
      std::max(params.min_prior_sigma_rad, std::sqrt(expected.covariance(2, 2)));
  return prior;
}

std::optional<Look> Localizer::Impl::LookAt(const Patch& at,
                                            const FrameSpectrum& spectrum,
                                            const std::optional<PoseEstimate>& expected,
                                            double* scale) {
  Registrar& active = scale_known ? registrar : scaling;
  std::optional<MotionPrior> prior;
  if (expected) prior = PriorFor(at, *expected);
  Registration found = active.Register(at.spectrum, spectrum, prior);
  if (found.verdict == Verdict::kAmbiguous) ++ambiguous_looks;
  if (!found.ok()) return std::nullopt;
  if (std::abs(std::log(found.motion.scale)) > params.max_scale_error) return std::nullopt;
  if (scale != nullptr) *scale = found.motion.scale;
  // The shift in pixels of the patch, whose size on the ceiling is known.
  found.motion.tx_px /= found.motion.scale;
  found.motion.ty_px /= found.motion.scale;
  found.motion.scale = 1;
  const mapping::Edge edge = mapping::MeasuredEdge(view, found, 0, 1, params.noise);
  Look look;
  look.pose = Moved({at.T_map_base}, edge.T_from_to, edge.information.inverse());
  look.by_prior = found.by_prior;
  look.peak = found.peak;
  look.inliers = found.inliers;
  look.blocks = found.blocks;
  return look;
}

// What the frame's own blocks say of the map at the place: the frame is the reference, so that
// places can be weighed against each other.
void Localizer::Impl::Compare(const Patch& at, const FrameSpectrum& spectrum, Look& look) {
  const registration::ImageMotion to_map =
      mapping::ImageMotionOf(view, look.pose.T_map_base.Inverse() * at.T_map_base);
  look.unlike = registrar.Compare(spectrum, at.spectrum, to_map);
}

double Localizer::Impl::Overlap(const Patch& at, const Pose2& T_map_base) const {
  return registration::OverlapOf(mapping::ImageMotionOf(view, at.T_map_base.Inverse() * T_map_base),
                                 view.Size());
}

/// Keeps the patch while enough of it is in view; the next one lies ahead, so that it lasts.
void Localizer::Impl::ChoosePatch(const PoseEstimate& expected) {
  const Pose2& T_map_base = expected.T_map_base;
  if (patch && Overlap(*patch, T_map_base) >= params.min_overlap) return;
  constexpr double kSlow = 0.05;       // m/s: no direction to speak of
  constexpr double kAheadPart = 0.17;  // of the span
  const Eigen::Vector2d velocity = motion.Velocity().head<2>();
  if (velocity.norm() > kSlow) {
    const Eigen::Vector2d ahead = kAheadPart * span * velocity.normalized();
    patch = patches->Near(T_map_base * Pose2{ahead.x(), ahead.y(), 0});
    if (patch && Overlap(*patch, T_map_base) >= params.min_overlap) return;
  }
  patch = patches->Near(T_map_base);
}

void Localizer::Impl::Place(const Look& look, Location& location) {
  location.pose.T_map_base = look.pose.T_map_base;
  location.pose.covariance = look.pose.covariance + shape.At(look.pose.T_map_base);
  location.peak = look.peak;
  location.inliers = look.inliers;
  location.blocks = look.blocks;
}

bool Localizer::Impl::Track(const CeilingFrame& frame,
                            const FrameSpectrum& spectrum,
                            const std::optional<HeadingPrior>& yaw,
                            Location& location) {
  motion.Predict(frame.stamp_s);
  if (yaw) motion.UpdateYaw(yaw->heading_rad, yaw->variance_rad2);
  PoseEstimate expected = motion.Pose();
  ChoosePatch(expected);
  if (!patch) return false;
  double scale = 1;
  const std::optional<Look> look = LookAt(*patch, spectrum, expected, &scale);
  if (!look) return false;
  const double floor = params.min_prior_sigma_px * view.MetresPerPixel();
  const double floor_rad = params.min_prior_sigma_rad;
  expected.covariance.diagonal() +=
      Eigen::Vector3d(floor * floor, floor * floor, floor_rad * floor_rad);
  if (SquaredDistance(look->pose, expected) > params.max_sigmas * params.max_sigmas) return false;
  motion.Update(look->pose);
  Place(*look, location);
  location.pose.status = TrackingStatus::kTracking;
  if (!scale_known) LearnScale(scale);
  return true;
}

void Localizer::Impl::LearnScale(double scale) {
  scales.push_back(scale);
  if (static_cast<int>(scales.size()) < params.scale_frames) return;
  const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
  std::nth_element(scales.begin(), middle, scales.end());
  scale_known = true;
  report.scale = *middle;
  patch.reset();
  patches.reset();
  view = MakeView(up, map.Metadata().ceiling_height_m, *middle);
  patches = std::make_unique<MapPatches>(map, view, registrar, params.patches);
  chain.Reset();
}

/// By the robot's own motion as far as it can be seen.
void Localizer::Impl::MoveHypotheses(const CeilingFrame& frame,
                                     const cv::Mat& picture,
                                     bool& seen) {
  const std::optional<ChainStep> step = chain.Next(picture, frame.index, frame.stamp_s);
  seen = step || chain.Began();
  if (step) {
    hypotheses.Move(step->T_before_now, step->covariance, !step->by_prior);
  } else if (chain.Broken()) {
    const double unseen_s = frame.stamp_s - seen_stamp_s;
    hypotheses.Spread(params.unseen_speed * unseen_s, params.unseen_turn * unseen_s);
  }
  if (seen) seen_stamp_s = frame.stamp_s;
}

bool Localizer::Impl::Wanted(const PlaceProposal& place,
                             double stamp_s,
                             const std::optional<HeadingPrior>& yaw) const {
  constexpr double kSigmas = 4;
  constexpr double kProposal_rad = 0.1;  // what a proposal may be off by
  Pose2 T_map_base = place.T_map_base;
  if (yaw && !place.any_yaw) {
    const double off = calib::WrapAngle(T_map_base.yaw - yaw->heading_rad);
    if (std::abs(off) > kSigmas * std::sqrt(yaw->variance_rad2) + kProposal_rad) return false;
  }
  if (!params.start || frames_of_start > params.give_up_start_after) return true;
  const double elapsed_s = stamp_s - *first_stamp_s;
  const double moved = params.unseen_speed * elapsed_s + 0.1 * span;
  const double turned = params.unseen_turn * elapsed_s + kProposal_rad;
  PoseEstimate start = *params.start;
  if (place.any_yaw) T_map_base.yaw = start.T_map_base.yaw;
  start.covariance.diagonal() += Eigen::Vector3d(moved * moved, moved * moved, turned * turned);
  return SquaredDistance(start, {T_map_base}) < kSigmas * kSigmas;
}

std::optional<Look> Localizer::Impl::LookNear(const Pose2& T_map_base,
                                              const FrameSpectrum& spectrum,
                                              const std::optional<PoseEstimate>& expected) {
  const std::shared_ptr<const Patch> at = patches->Near(T_map_base);
  if (!at) return std::nullopt;
  std::optional<Look> look = LookAt(*at, spectrum, expected);
  if (look) Compare(*at, spectrum, *look);
  return look;
}

/// All over the map, where it looks like the picture.
void Localizer::Impl::LookElsewhere(double stamp_s,
                                    const cv::Mat& picture,
                                    const FrameSpectrum& spectrum,
                                    const std::optional<HeadingPrior>& yaw) {
  ++report.searches;
  const double sigma = 0.5 * params.places.same_part * span;
  constexpr double kProposalVariance = 0.01;  // rad^2
  Eigen::Matrix3d rough = Eigen::Matrix3d::Zero();
  rough.diagonal() << sigma * sigma, sigma * sigma, kProposalVariance;
  const auto wanted = [&](const PlaceProposal& place) { return Wanted(place, stamp_s, yaw); };
  // Where a picture fits in several ways within each place, it does so everywhere.
  constexpr int kEnoughAmbiguous = 3;
  for (const PlaceProposal& place : finder.Find(picture, wanted)) {
    if (ambiguous_looks >= kEnoughAmbiguous) break;
    if (!place.any_yaw && hypotheses.Knows(place.T_map_base)) continue;
    std::optional<PoseEstimate> expected;
    if (!place.any_yaw) expected = {place.T_map_base, rough};
    const std::optional<Look> look = LookNear(place.T_map_base, spectrum, expected);
    // A look that more than one pose explains is no news of where the robot is.
    if (look && !look->by_prior) hypotheses.Add(*look);
  }
}

void Localizer::Impl::Search(const CeilingFrame& frame,
                             const cv::Mat& picture,
                             const FrameSpectrum& spectrum,
                             const std::optional<HeadingPrior>& yaw,
                             Location& location) {
  location.pose.status = TrackingStatus::kLost;
  bool seen = false;
  MoveHypotheses(frame, picture, seen);
  if (!seen) return;
  ++frames_of_start;
  ambiguous_looks = 0;
  hypotheses.LookAtAll(
      [&](const Hypothesis& h) { return LookNear(h.pose.T_map_base, spectrum, h.pose); });
  if (hypotheses.Sure() == nullptr) LookElsewhere(frame.stamp_s, picture, spectrum, yaw);
  hypotheses.Weigh();
  location.hypotheses = static_cast<int>(hypotheses.All().size());
  if (const Hypothesis* sure = hypotheses.Sure()) {
    Place(sure->look, location);
    location.pose.status = was_placed ? TrackingStatus::kTracking : TrackingStatus::kRelocalized;
    motion.Start(sure->look.pose, frame.stamp_s);
    hypotheses.Clear();
    patch.reset();
    frames_of_start = params.give_up_start_after + 1;
  } else if (ambiguous_looks > 0 || hypotheses.AnyLook()) {
    location.pose.status = TrackingStatus::kAmbiguous;
  }
}

Localizer::Localizer(const mapping::MapReader& map,
                     const calib::MountedCamera& up,
                     const LocalizerParams& params) {
  params.Validate();
  impl_ = std::make_unique<Impl>(map, up, params);
}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

Location Localizer::Locate(const CeilingFrame& frame) {
  Impl& me = *impl_;
  me.Check(frame);
  Location location;
  location.pose.frame_index = frame.index;
  location.pose.stamp_s = frame.stamp_s;
  auto start = Clock::now();
  const cv::Mat& picture = me.view.Rectify(frame.grey, me.rectified);
  me.report.rectify_ms += MillisecondsSince(start);
  start = Clock::now();
  const FrameSpectrum spectrum = me.registrar.Analyze(picture);
  me.report.analyze_ms += MillisecondsSince(start);
  if (!me.first_stamp_s) me.first_stamp_s = frame.stamp_s;
  std::optional<HeadingPrior> yaw;
  if (frame.heading) yaw = me.heading.InMap(*frame.heading, frame.stamp_s);

  start = Clock::now();
  bool tracked = false;
  if (me.motion.Started()) {
    tracked = me.Track(frame, spectrum, yaw, location);
    me.report.track_ms += MillisecondsSince(start);
    if (!tracked) {
      // From now on as somebody who knows where he was a moment ago.
      me.motion.Stop();
      me.hypotheses.Clear();
      me.hypotheses.Trust(me.last_pose);
      me.chain.Reset();
      (void)me.chain.Next(me.last_picture, me.last_index, *me.last_stamp_s);
      me.seen_stamp_s = *me.last_stamp_s;
    }
  }
  if (!tracked) {
    start = Clock::now();
    me.Search(frame, picture, spectrum, yaw, location);
    me.report.search_ms += MillisecondsSince(start);
  }
  me.was_placed = location.Placed();
  if (location.Placed()) {
    me.last_pose = {location.pose.T_map_base,
                    location.pose.covariance - me.shape.At(location.pose.T_map_base)};
    picture.copyTo(me.last_picture);
    me.last_index = frame.index;
    if (frame.heading) {
      me.heading.Learn(*frame.heading,
                       location.pose.T_map_base.yaw,
                       location.pose.covariance(2, 2),
                       frame.stamp_s);
    }
  }
  me.last_stamp_s = frame.stamp_s;
  ++me.report.frames;
  switch (location.pose.status) {
    case TrackingStatus::kTracking:
      ++me.report.tracking;
      break;
    case TrackingStatus::kRelocalized:
      ++me.report.relocalized;
      break;
    case TrackingStatus::kAmbiguous:
      ++me.report.ambiguous;
      break;
    case TrackingStatus::kLost:
      ++me.report.lost;
      break;
  }
  return location;
}

void Localizer::Reset() {
  Impl& me = *impl_;
  me.motion.Stop();
  me.hypotheses.Clear();
  me.chain.Reset();
  me.heading = HeadingFusion(me.params.heading);
  me.patch.reset();
  me.was_placed = false;
  me.frames_of_start = me.params.give_up_start_after + 1;
}

const LocalizerReport& Localizer::Report() const {
  return impl_->report;
}

}  // namespace ceilmap::localization
