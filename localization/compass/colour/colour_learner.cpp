#include "localization/compass/colour/colour_learner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/strip_turn.hpp"

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

/// Estimates the distance of the surroundings from turns about an axle behind the camera. The
/// measured turns exceed the true ones by the ratio of the camera's distance from the axle to the
/// distance of the objects.
class DepthMeter {
 public:
  void Add(double turned_rad, double measured_rad) {
    constexpr double kMin = 0.008;  // rad: noise dominates below it
    constexpr double kMax = 0.5;
    if (std::abs(turned_rad) < kMin || std::abs(turned_rad) > kMax) return;
    turned_ += std::abs(turned_rad);
    measured_ += turned_rad > 0 ? measured_rad : -measured_rad;
  }
  [[nodiscard]] std::optional<double> Depth(double camera_ahead_of_axle_m) const {
    constexpr double kMinAhead = 0.05;
    constexpr double kNearest = 1;
    constexpr double kMaxDepths = 20;
    if (camera_ahead_of_axle_m < kMinAhead || turned_ < pi) return std::nullopt;
    const double excess = measured_ / turned_ - 1;
    if (!(excess > camera_ahead_of_axle_m / kMaxDepths)) return std::nullopt;
    return std::max(kNearest, camera_ahead_of_axle_m / excess);
  }

 private:
  double turned_ = 0;
  double measured_ = 0;
};

struct Kept {
  cv::Mat samples;
  double stamp_s = 0;
  LearnedPose pose;
  std::shared_ptr<const ScanLines> lines;
};

GridGeometry AboutTheMiddle(const std::vector<Kept>& frames) {
  Eigen::Vector2d least = frames.front().pose.T_map_base.Translation();
  Eigen::Vector2d most = least;
  for (const Kept& frame : frames) {
    least = least.cwiseMin(frame.pose.T_map_base.Translation());
    most = most.cwiseMax(frame.pose.T_map_base.Translation());
  }
  GridGeometry grid;
  grid.min_x_m = 0.5 * (least.x() + most.x() - grid.width_m);
  grid.min_y_m = 0.5 * (least.y() + most.y() - grid.height_m);
  return grid;
}

int CellAt(const ColourModel& model, const Eigen::Vector2d& place) {
  return model.kind == ModelKind::kSturm ? 0 : model.grid.CellOf(place);
}

/// p(l) of an observation in its cell.
double PlaceCertainty(const LearnedPose& pose, const ColourModel& model) {
  if (pose.places.empty()) {
    constexpr double kScaleM = 0.5;
    const double place = pose.sigma_m / kScaleM;
    return 1 / (1 + place * place);
  }
  const int cell = CellAt(model, pose.T_map_base.Translation());
  double here = 0;
  double all = 0;
  for (const PlaceHypothesis& hypothesis : pose.places) {
    all += hypothesis.weight;
    if (CellAt(model, hypothesis.place) == cell) here += hypothesis.weight;
  }
  return here / all;
}

/// Weight of an observation in its cell and a bin, given the uncertainty of its position and
/// heading: p(l) p(alpha).
double CertaintyOf(const LearnedPose& pose, const ColourModel& model) {
  const double yaw = pose.sigma_rad * model.bins / (2 * pi);
  return PlaceCertainty(pose, model) / (1 + yaw * yaw);
}

void ObserveLine(const Eigen::Ref<const Eigen::RowVectorXf>& observed,
                 double certainty,
                 double stamp_s,
                 const Eigen::Vector2d& place,
                 const ColourModel& model,
                 AngleBin& bin) {
  if (!(certainty > 1e-6)) return;
  if (bin.empty()) {
    bin.transitions = observed.transpose();
    if (model.kind == ModelKind::kSturm) bin.variance.setZero(observed.size());
    bin.certainty = certainty;
    bin.place = place;
    bin.stamp_s = stamp_s;
    return;
  }
  // Old observations have less weight: what has changed is replaced, what has not is averaged.
  const double before = FadedCertainty(bin, stamp_s, model.fading_s);
  const auto fraction = static_cast<float>(certainty / (before + certainty));
  const Eigen::VectorXf off = observed.transpose() - bin.transitions;
  bin.transitions += fraction * off;
  if (model.kind == ModelKind::kSturm) {
    bin.variance = (1 - fraction) * (bin.variance + fraction * off.cwiseAbs2());
  }
  bin.place += static_cast<double>(fraction) * (place - bin.place);
  constexpr double kMax = 4;
  bin.certainty = std::min(before + certainty, kMax);
  bin.stamp_s = std::max(bin.stamp_s, stamp_s);
}

/// m(f_new) > m(f_old): "the cell's old feature is replaced by the new feature".
void ReplaceLine(const Eigen::Ref<const Eigen::RowVectorXf>& observed,
                 double certainty,
                 double stamp_s,
                 const Eigen::Vector2d& place,
                 double fading_s,
                 AngleBin& bin) {
  if (!(certainty > 1e-6)) return;
  if (!bin.empty() && certainty <= FadedCertainty(bin, stamp_s, fading_s)) return;
  bin.transitions = observed.transpose();
  bin.certainty = certainty;
  bin.place = place;
  bin.stamp_s = stamp_s;
}

Clustering ResolvedClustering(Clustering wanted, ModelKind kind) {
  if (wanted != Clustering::kOfMethod) return wanted;
  return kind == ModelKind::kSturm ? Clustering::kMixture : Clustering::kMeans;
}

}  // namespace

void LearnParams::Validate() const {
  classes.Validate();
  lines.Validate();
  if (grid) {
    grid->Validate();
    CheckBinCount(grid->Cells(), bins);
  }
  if (bins < 36 || bins > 720) {
    throw InputError(fmt::format("bins = {}, must be 36 to 720", bins));
  }
  if (depth_m && !(*depth_m > 0)) {
    throw InputError(fmt::format("depth_m = {}, must be > 0", *depth_m));
  }
  if (!(fading_s > 0)) throw InputError(fmt::format("fading_s = {}, must be > 0", fading_s));
}

struct ColourLearner::Impl {
  Impl(calib::MountedCamera camera, const LearnParams& wanted)
      : forward(std::move(camera)), params(wanted), strip(forward), lines(forward, params.lines) {
    params.Validate();
  }

  calib::MountedCamera forward;
  LearnParams params;
  StripTurn strip;
  DepthMeter depth;
  LearnCounts counts;
  std::vector<Kept> frames;
  ScanLinesByTilt lines;
  std::optional<double> last_yaw;
};

ColourLearner::ColourLearner(const calib::MountedCamera& forward, const LearnParams& params)
    : impl_(std::make_unique<Impl>(forward, params)) {}
ColourLearner::~ColourLearner() = default;
ColourLearner::ColourLearner(ColourLearner&&) noexcept = default;
ColourLearner& ColourLearner::operator=(ColourLearner&&) noexcept = default;

bool ColourLearner::Add(const cv::Mat& bgr, double stamp_s, const LearnedPose& pose) {
  Impl& me = *impl_;
  Kept frame{{}, stamp_s, pose, me.lines.For(pose.tilt)};
  if (!frame.lines->Usable()) {
    ++me.counts.below_horizon;
    me.strip.Reset();
    me.last_yaw.reset();
    return false;
  }
  frame.lines->Sample(bgr, frame.samples);
  const auto turned = me.strip.Next(bgr);
  if (turned && me.last_yaw) {
    me.depth.Add(WrapAngle(pose.T_map_base.yaw - *me.last_yaw), turned->turn_rad);
  }
  me.last_yaw = pose.T_map_base.yaw;
  me.frames.push_back(std::move(frame));
  ++me.counts.used;
  return true;
}

const LearnCounts& ColourLearner::Counts() const {
  return impl_->counts;
}

ColourModel ColourLearner::Finish() const {
  const Impl& me = *impl_;
  if (me.frames.empty()) {
    throw InputError(
        fmt::format("nothing to learn from: {} frames at known poses, of which {} show too little "
                    "above the horizon; raise the camera",
                    me.counts.below_horizon,
                    me.counts.below_horizon));
  }
  std::vector<cv::Mat> samples;
  for (const Kept& frame : me.frames) {
    for (int i = 0; i < frame.samples.rows; ++i) {
      samples.push_back(
          frame.samples.row(i).colRange(0, frame.lines->Length(static_cast<std::size_t>(i))));
    }
  }
  cv::Mat all;
  cv::hconcat(samples, all);
  ColourClassParams wanted = me.params.classes;
  wanted.clustering = ResolvedClustering(wanted.clustering, me.params.kind);
  const ColourClasses classes = ColourClasses::Learn(all, wanted);

  ColourModel model;
  model.kind = me.params.kind;
  model.classes = classes.Classes();
  model.bins = me.params.bins;
  model.grid = me.params.grid.value_or(AboutTheMiddle(me.frames));
  model.fading_s = me.params.fading_s;
  const auto measured = me.depth.Depth(me.params.camera_ahead_of_axle_m);
  model.depth_m = me.params.depth_m.value_or(measured.value_or(model.depth_m));
  const int cells = model.kind == ModelKind::kSturm ? 1 : model.grid.Cells();
  model.cells.resize(static_cast<std::size_t>(cells));
  for (Cell& cell : model.cells) cell.bins.resize(static_cast<std::size_t>(model.bins));
  LineFeatures features;
  for (const Kept& frame : me.frames) {
    CountTransitions(frame.samples, *frame.lines, classes, features);
    Observe(features, frame.lines->Azimuths(), frame.stamp_s, frame.pose, model);
  }
  return model;
}

void Observe(const LineFeatures& features,
             const std::vector<double>& azimuths,
             double stamp_s,
             const LearnedPose& pose,
             ColourModel& model) {
  if (model.kind == ModelKind::kVictoria2013) {
    Replace(features, azimuths, stamp_s, pose, model);
    return;
  }
  const Eigen::Vector2d place = pose.T_map_base.Translation();
  const auto cell = static_cast<std::size_t>(CellAt(model, place));
  std::vector<AngleBin>& bins = model.cells[cell].bins;
  const auto count = static_cast<double>(bins.size());
  const double certainty = CertaintyOf(pose, model);
  for (std::size_t i = 0; i < azimuths.size(); ++i) {
    const double angle = (pose.T_map_base.yaw + azimuths[i]) / (2 * pi);
    const double at = (angle - std::floor(angle)) * count - 0.5;  // centres of bins: 0, 1, ...
    const double lower = std::floor(at);
    const double fraction = at - lower;
    const auto bin = [&](double wanted) -> AngleBin& {
      return bins[static_cast<std::size_t>(wanted < 0 ? wanted + count : wanted) % bins.size()];
    };
    const auto row = features.row(static_cast<Eigen::Index>(i));
    ObserveLine(row, (1 - fraction) * certainty, stamp_s, place, model, bin(lower));
    ObserveLine(row, fraction * certainty, stamp_s, place, model, bin(lower + 1));
  }
  ++model.frames;
}

void Replace(const LineFeatures& features,
             const std::vector<double>& azimuths,
             double stamp_s,
             const LearnedPose& pose,
             ColourModel& model) {
  const Eigen::Vector2d place = pose.T_map_base.Translation();
  const auto cell = static_cast<std::size_t>(CellAt(model, place));
  std::vector<AngleBin>& bins = model.cells[cell].bins;
  const double certainty = CertaintyOf(pose, model);
  for (std::size_t i = 0; i < azimuths.size(); ++i) {
    const int bin = BinOf(pose.T_map_base.yaw + azimuths[i], static_cast<int>(bins.size()));
    ReplaceLine(features.row(static_cast<Eigen::Index>(i)),
                certainty,
                stamp_s,
                place,
                model.fading_s,
                bins[static_cast<std::size_t>(bin)]);
  }
  ++model.frames;
}

}  // namespace ceilmap::colour
