#include "localization/compass/colour/colour_compass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/colour/frame_reader.hpp"
#include "localization/compass/colour/line_matcher.hpp"
#include "localization/compass/colour/place_grid.hpp"
#include "localization/compass/colour/strip_turn.hpp"
#include "localization/compass/colour/yaw_belief.hpp"

namespace ceilmap::colour {
namespace {

// Expected dissimilarity of the features of a correct line, as a ratio of the largest possible
// dissimilarity; smaller differences do not raise the likelihood, > 0.
constexpr double kLineNoise = 0.005;
// Expected fraction of the lines that differ from what was learned in their direction (people,
// objects added or removed), [0, 1).
constexpr double kChangedFraction = 0.3;

constexpr double kExposureDrift = 0.01;
// Number of independent lines that all lines of a frame together are equivalent to, because
// neighbouring lines observe the same objects, > 0.
constexpr double kEffectiveLines = 5;
// A frame that shows the same content as the previous one contains no new information. A frame
// has full weight after a turn of this angle, rad > 0, ...
constexpr double kFreshTurnRad = 0.3;
// ... and at least this fraction of the full weight otherwise, (0, 1].
constexpr double kMinFresh = 0.1;
// Standard deviation of the measured turn between frames: a constant, rad >= 0, and a ratio of
// the turn, >= 0.
constexpr double kTurnSigmaRad = 0.004;
constexpr double kTurnSigmaRatio = 0.02;
// Standard deviation of the robot's turn rate where no turn can be measured (darkness, no
// overlap), rad/s, > 0.
constexpr double kUnseenRateRadS = 0.6;
// Standard deviation of the distance travelled by a robot with unknown position, in addition to
// the measured motion: a ratio of that motion, >= 0, and m/sqrt(s), >= 0.
constexpr double kWaySigmaRatio = 0.3;
constexpr double kWaySigmaM = 0.1;
// The same where the motion cannot be measured, m/sqrt(s).
constexpr double kUnseenWaySigmaM = 1;
// Largest distance of a possible position from a learned one, as a ratio of the depth, [0, 0.9].
constexpr double kReach = 0.75;
// Error of the cylinder as a model of the room: standard deviation of the heading per
// displacement from the learned position (as a ratio of the depth), >= 0, rad; for estimated
// positions, and for given positions.
constexpr double kModelSigmaRad = 0.2;
constexpr double kModelSigmaKnownRad = 0.06;
// Only cells that contain at least this fraction of the total weight of the possible positions
// are compared (ViCTORiA), [0, 1]. Used for given positions only.
constexpr double kMinCellRatio = 0.2;

using std::numbers::pi;

constexpr double kSpacing = 0.15;  // of places, as a ratio of the depth
constexpr double kMaxOffset = 0.9;
constexpr double kElsewhere = 0.5;  // initial probability
constexpr double kFarthest = 10;    // largest offset in the model error, in depths

int StepOf(double angle_rad) {
  const double turns = angle_rad / (2 * pi);
  const int step =
      static_cast<int>(std::lround((turns - std::floor(turns)) * DirectionTable::kSteps));
  return step % DirectionTable::kSteps;
}

Eigen::Vector2d MeanOf(std::span<const PlaceHypothesis> hypotheses) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0;
  for (const PlaceHypothesis& hypothesis : hypotheses) {
    sum += hypothesis.weight * hypothesis.place;
    weights += hypothesis.weight;
  }
  return sum / weights;
}

}  // namespace

void ColourCompassParams::Validate() const {
  lines.Validate();
  const FieldCheck require("colour compass");
  require(exposure_sigma >= 0, "exposure_sigma", exposure_sigma, ">= 0");
}

struct ColourCompass::Impl {
  Impl(ColourModel learned, calib::MountedCamera camera, const ColourCompassParams& wanted)
      : model(std::move(learned)),
        forward(std::move(camera)),
        params((wanted.Validate(), wanted)),
        matcher((Check(model), model), kLineNoise, kChangedFraction),
        strip(forward),
        reader(model.classes,
               model.kind == ModelKind::kSturm ? 0 : params.exposure_sigma,
               kExposureDrift),
        lines(forward, params.lines) {
    turn_scale = 1 / (1 + std::max(0.0, params.camera_ahead_of_axle_m) / model.depth_m);
    SetPlaces();
  }

  static void Check(const ColourModel& model);
  void SetPlaces();
  void Predict(const ColourFrame& frame);
  void Compare(int cell);
  /// @param evidence  Log-likelihood ratio of the frame under the estimated distribution and under
  ///   any direction of the room.
  void Discount(double evidence);
  void WeighExposures(const Eigen::Vector2d& at);
  [[nodiscard]] Eigen::Vector2d MeanPlace() const;
  [[nodiscard]] double ConfidenceOf(const YawBelief::Estimate& yaw) const {
    return model.kind == ModelKind::kSturm ? yaw.confidence : (1 - elsewhere) * yaw.confidence;
  }
  double WeighAll();
  double WeighKnown(std::span<const PlaceHypothesis> hypotheses);
  /// Log-likelihood of each yaw at a place. @param fit  Fit of the place's cell.
  void FitAt(const LineFit& fit, const DirectionTable& directions, float* fit_of_yaws) const;
  [[nodiscard]] const LineFit& FitOf(int cell) const {
    return fits[static_cast<std::size_t>(cell)];
  }

  ColourModel model;
  calib::MountedCamera forward;
  ColourCompassParams params;
  LineMatcher matcher;
  StripTurn strip;
  FrameReader reader;
  double turn_scale = 1;
  double elsewhere = kElsewhere;  // probability that no yaw and place of the distribution is right
  double fresh = 1;               // fraction of the frame that is new information
  ColourCounts counts;
  std::vector<Place> places;
  std::optional<YawBelief> belief;
  ScanLinesByTilt lines;
  std::optional<double> last_s;
  std::optional<double> used_s;  // of the frame that the reader has read; unset: it was skipped

  cv::Mat samples;
  LineFit one_fit;
  std::vector<LineFit> fits;    // of each cell
  std::vector<char> fitted;     // whether the fit of a cell is that of this frame
  std::vector<int> line_steps;  // directions of the lines' azimuths, in steps
  YawBelief::Histogram weights;
};

void ColourCompass::Impl::Check(const ColourModel& model) {
  model.Validate();
  if (std::all_of(
          model.cells.begin(), model.cells.end(), [](const Cell& c) { return c.empty(); })) {
    throw InputError("the model is empty: it has learned nothing yet");
  }
}

void ColourCompass::Impl::SetPlaces() {
  const bool one = !params.parallax || model.kind == ModelKind::kSturm;
  places = PlacesAround(model, one ? 0 : kReach, kSpacing);
  belief.emplace(static_cast<int>(places.size()));
  fits.resize(model.cells.size());
}

void ColourCompass::Impl::Predict(const ColourFrame& frame) {
  const std::optional<MeasuredTurn> turned = strip.Next(frame.bgr);
  fresh = 1;
  if (!last_s) return;
  const double seconds = frame.stamp_s - *last_s;
  const double step_m = kSpacing * model.depth_m;
  double sigma_m = kUnseenWaySigmaM * std::sqrt(seconds);
  if (turned) {
    const double turn = turn_scale * turned->turn_rad;
    // Where objects are nearer on one side, driving past them appears as a turn.
    constexpr double kSideways = 0.1;
    belief->Turn(turn,
                 std::hypot(kTurnSigmaRad, kTurnSigmaRatio * turn, kSideways * turned->ahead));
    fresh = std::clamp((std::abs(turn) + std::abs(turned->ahead)) / kFreshTurnRad, kMinFresh, 1.0);
    const double travelled_m = turned->ahead * model.depth_m;
    belief->Drive(travelled_m / step_m, places);
    sigma_m = std::hypot(kWaySigmaRatio * travelled_m, kWaySigmaM * std::sqrt(seconds));
  } else {
    ++counts.without_turn;
    fresh = kMinFresh;  // nothing is known about the change of the view
    belief->Turn(0, kUnseenRateRadS * seconds);
  }
  const double fraction = 0.5 * sigma_m * sigma_m / (step_m * step_m);
  constexpr double kMaxFraction = 0.2;
  belief->Walk(places, static_cast<float>(std::min(kMaxFraction, fraction)));
  reader.Wait(seconds);
}

// Computes the fit of the frame under the current distribution, at each exposure.
void ColourCompass::Impl::WeighExposures(const Eigen::Vector2d& at) {
  const std::span<const Reading> readings = reader.Readings();
  if (readings.size() < 2) return;
  const Place& place =
      *std::min_element(places.begin(), places.end(), [&at](const Place& a, const Place& b) {
        return (a.at - at).squaredNorm() < (b.at - at).squaredNorm();
      });
  const Eigen::RowVectorXf yaws = belief->Yaws();
  Eigen::RowVectorXf fit_of_yaws(YawBelief::kYaws);
  std::vector<double> evidence;
  evidence.reserve(readings.size());
  for (const Reading& reading : readings) {
    matcher.Fit(reading.features, place.cell, one_fit);
    FitAt(one_fit, place.directions, fit_of_yaws.data());
    const float most = fit_of_yaws.maxCoeff();
    const double sum = yaws.dot((fit_of_yaws.array() - most).exp().matrix());
    evidence.push_back(double{most} + std::log(std::max(sum, 1e-30)));
  }
  reader.Weigh(evidence);
}

// In addition to all yaws and places there is one more hypothesis: the place was not learned, or
// the surroundings have changed too much to give information. Under it a line resembles any line of
// the room. This is the reference of FitChanging, so its evidence is 0.
void ColourCompass::Impl::Discount(double evidence) {
  if (model.kind == ModelKind::kSturm) return;  // its likelihood has no such scale
  const double odds = (1 - elsewhere) / elsewhere * std::exp(std::clamp(evidence, -50.0, 50.0));
  constexpr double kMin = 0.01;  // the hypothesis can become true, and false again
  elsewhere = kMin + (1 - 2 * kMin) / (1 + odds);
}

Eigen::Vector2d ColourCompass::Impl::MeanPlace() const {
  const Eigen::VectorXf parts = belief->Places();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    mean += static_cast<double>(parts(static_cast<Eigen::Index>(i))) * places[i].at;
  }
  return mean;
}

void ColourCompass::Impl::Compare(int cell) {
  if (fitted[static_cast<std::size_t>(cell)] != 0) return;
  matcher.FitChanging(reader.Readings(), cell, fits[static_cast<std::size_t>(cell)]);
  fitted[static_cast<std::size_t>(cell)] = 1;
}

void ColourCompass::Impl::FitAt(const LineFit& fit,
                                const DirectionTable& directions,
                                float* fit_of_yaws) const {
  const auto scale = static_cast<float>(fresh * kEffectiveLines / static_cast<double>(fit.rows()));
  // The columns of the distribution are a whole number of steps apart.
  static_assert(DirectionTable::kSteps % YawBelief::kYaws == 0);
  constexpr int kStride = DirectionTable::kSteps / YawBelief::kYaws;
  int step = StepOf(belief->YawOf(0));
  for (int yaw = 0; yaw < YawBelief::kYaws; ++yaw, step += kStride) {
    if (step >= DirectionTable::kSteps) step -= DirectionTable::kSteps;
    float sum = 0;
    for (std::size_t i = 0; i < line_steps.size(); ++i) {
      int at = step + line_steps[i];
      if (at >= DirectionTable::kSteps) at -= DirectionTable::kSteps;
      const DirectionTable::Entry& entry = directions.At(at);
      const float* row = fit.row(static_cast<Eigen::Index>(i)).data();
      sum += row[entry.lower] + entry.fraction * (row[entry.upper] - row[entry.lower]);
    }
    fit_of_yaws[yaw] = scale * sum;
  }
}

double ColourCompass::Impl::WeighAll() {
  weights.resize(static_cast<Eigen::Index>(places.size()), YawBelief::kYaws);
  for (std::size_t i = 0; i < places.size(); ++i) {
    Compare(places[i].cell);
    FitAt(FitOf(places[i].cell),
          places[i].directions,
          weights.row(static_cast<Eigen::Index>(i)).data());
  }
  return belief->Weigh(weights);
}

double ColourCompass::Impl::WeighKnown(std::span<const PlaceHypothesis> hypotheses) {
  double all = 0;
  std::vector<double> of_cell(model.cells.size(), 0.0);
  std::vector<int> cells;
  for (const PlaceHypothesis& hypothesis : hypotheses) {
    if (!(hypothesis.weight > 0) || !hypothesis.place.allFinite()) {
      throw InputError("a place where the robot may be must be finite, its weight > 0");
    }
    cells.push_back(NearestLearned(model, hypothesis.place));
    of_cell[static_cast<std::size_t>(cells.back())] += hypothesis.weight;
    all += hypothesis.weight;
  }
  const double most = *std::max_element(of_cell.begin(), of_cell.end());
  const double least = std::min(kMinCellRatio * all, most);
  Eigen::RowVectorXf likelihood = Eigen::RowVectorXf::Zero(YawBelief::kYaws);
  Eigen::RowVectorXf fit(YawBelief::kYaws);
  Eigen::VectorXf near = Eigen::VectorXf::Constant(static_cast<Eigen::Index>(places.size()), 1e-6F);
  std::optional<float> top;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (of_cell[static_cast<std::size_t>(cells[i])] < least) continue;
    Compare(cells[i]);
    const bool parallax = params.parallax && model.kind != ModelKind::kSturm;
    const Eigen::Vector2d offset =
        parallax ? OffsetFrom(model, cells[i], hypotheses[i].place, kMaxOffset)
                 : Eigen::Vector2d(Eigen::Vector2d::Zero());
    FitAt(FitOf(cells[i]), DirectionTable(offset, model.bins), fit.data());
    if (!top) top = fit.maxCoeff();
    const auto weight = static_cast<float>(hypotheses[i].weight / all);
    likelihood.array() += weight * (fit.array() - *top).min(60.F).exp();
    const double width = kSpacing * model.depth_m;
    for (std::size_t p = 0; p < places.size(); ++p) {
      const double away = (places[p].at - hypotheses[i].place).norm() / width;
      near(static_cast<Eigen::Index>(p)) +=
          weight * static_cast<float>(std::exp(-0.5 * away * away));
    }
  }
  return double{*top} + belief->WeighYaws(likelihood, near);
}

ColourCompass::ColourCompass(ColourModel model,
                             const calib::MountedCamera& forward,
                             const ColourCompassParams& params)
    : impl_(std::make_unique<Impl>(std::move(model), forward, params)) {}
ColourCompass::~ColourCompass() = default;
ColourCompass::ColourCompass(ColourCompass&&) noexcept = default;
ColourCompass& ColourCompass::operator=(ColourCompass&&) noexcept = default;

std::optional<ColourHeading> ColourCompass::Next(const ColourFrame& frame) {
  Impl& me = *impl_;
  if (!std::isfinite(frame.stamp_s) || (me.last_s && frame.stamp_s <= *me.last_s)) {
    throw InputError(fmt::format("stamp {} is not later than the one before", frame.stamp_s));
  }
  const ScanLines& lines = *me.lines.For(frame.tilt);
  me.used_s.reset();
  if (!lines.Usable()) {
    ++me.counts.below_horizon;
    if (me.last_s) me.belief->Turn(0, kUnseenRateRadS * (frame.stamp_s - *me.last_s));
    me.last_s = frame.stamp_s;
    me.strip.Reset();
    return std::nullopt;
  }
  lines.Sample(frame.bgr, me.samples);
  me.Predict(frame);
  me.last_s = me.used_s = frame.stamp_s;
  me.reader.Read(me.samples, lines);
  me.line_steps.clear();
  for (const double azimuth : lines.Azimuths()) me.line_steps.push_back(StepOf(azimuth));
  me.fitted.assign(me.model.cells.size(), 0);
  if (frame.places.empty()) {
    me.WeighExposures(me.MeanPlace());
    me.Discount(me.WeighAll());
  } else {
    me.WeighExposures(MeanOf(frame.places));
    me.Discount(me.WeighKnown(frame.places));
  }
  ++me.counts.used;
  const YawBelief::Estimate yaw = me.belief->Yaw();
  ColourHeading heading{yaw.yaw_rad, yaw.variance_rad2, me.ConfidenceOf(yaw), me.MeanPlace()};
  const Eigen::Vector2d place = frame.places.empty() ? heading.place : MeanOf(frame.places);
  const int cell = NearestLearned(me.model, place);
  const double away = OffsetFrom(me.model, cell, place, kFarthest).norm();
  const double sigma = frame.places.empty() ? kModelSigmaRad : kModelSigmaKnownRad;
  heading.variance_rad2 += sigma * sigma * away * away;
  return heading;
}

void ColourCompass::Learn(const LearnedPose& pose) {
  Impl& me = *impl_;
  if (!me.used_s) return;
  const int cells = static_cast<int>(std::count_if(
      me.model.cells.begin(), me.model.cells.end(), [](const Cell& c) { return c.empty(); }));
  Observe(me.reader.Best().features, me.lines.Latest().Azimuths(), *me.used_s, pose, me.model);
  const bool one = me.model.kind == ModelKind::kSturm;
  me.matcher.Update(me.model, one ? 0 : me.model.grid.CellOf(pose.T_map_base.Translation()));
  const int left = static_cast<int>(std::count_if(
      me.model.cells.begin(), me.model.cells.end(), [](const Cell& c) { return c.empty(); }));
  if (left == cells) return;
  // A new cell adds possible places. The distribution of the yaw is kept.
  const Eigen::RowVectorXf before = me.belief->Yaws();
  const double turned = me.belief->Turned();
  me.SetPlaces();
  me.belief->Restore(before, turned);
}

void ColourCompass::Reset() {
  Impl& me = *impl_;
  me.SetPlaces();
  me.reader.Reset();
  me.elsewhere = kElsewhere;
  me.strip.Reset();
  me.last_s.reset();
  me.used_s.reset();
}

const ColourModel& ColourCompass::Model() const {
  return impl_->model;
}

const ColourCounts& ColourCompass::Counts() const {
  return impl_->counts;
}

}  // namespace ceilmap::colour
