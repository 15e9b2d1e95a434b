#include "localization/compass/colour/victoria2013_compass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/colour/asked_cells.hpp"
#include "localization/compass/colour/feature_similarity.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/strip_turn.hpp"

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

// Cells with at least this ratio of the position hypotheses are asked.
constexpr double kMinCellShare = 0.2;

ColourModel Checked(ColourModel model) {
  model.Validate();
  if (model.kind == ModelKind::kSturm) {
    throw InputError("the query victoria-2013 needs a grid of cells, but the model is of sturm");
  }
  if (std::all_of(
          model.cells.begin(), model.cells.end(), [](const Cell& c) { return c.empty(); })) {
    throw InputError("the model is empty: it has learned nothing yet");
  }
  return model;
}

SimilarityLimits LimitsFor(int bins) {
  SimilarityLimits limits;
  limits.angle_rad = pi / bins;
  return limits;
}

double NewestStamp(const ColourModel& model) {
  double newest = -std::numeric_limits<double>::infinity();
  for (const Cell& cell : model.cells) {
    for (const AngleBin& bin : cell.bins) {
      if (!bin.empty()) newest = std::max(newest, bin.stamp_s);
    }
  }
  return newest;
}

std::vector<AskedCell> AllLearned(const ColourModel& model) {
  std::vector<AskedCell> cells;
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    if (model.cells[c].empty()) continue;
    cells.push_back({static_cast<int>(c), 1, model.cells[c].Place()});
  }
  return cells;
}

/// Scores of the headings in a cell.
struct CellScores {
  Eigen::VectorXd full;   // by sim
  Eigen::VectorXd frame;  // by sim without 1 / diff(alpha): the frame alone
};

/// Variance of the headings around a chosen one with more than half of its score.
double VarianceAround(const Eigen::VectorXd& scores, Eigen::Index chosen, double width_rad) {
  const Eigen::Index count = scores.size();
  double weights = scores(chosen);
  double sum = 0;
  for (const int side : {-1, 1}) {
    for (Eigen::Index away = 1; away < count / 2; ++away) {
      const double score = scores((chosen + side * away + count) % count);
      if (score < 0.5 * scores(chosen)) break;
      const double off = static_cast<double>(away) * width_rad;
      weights += score;
      sum += score * off * off;
    }
  }
  return sum / weights + width_rad * width_rad / 12;
}

/// Largest score of a heading that is clearly another one, in any cell.
double Rival(const std::vector<CellScores>& cells, Eigen::Index chosen, double width_rad) {
  constexpr double kApartRad = pi / 9;
  double rival = 0;
  for (const CellScores& cell : cells) {
    for (Eigen::Index h = 0; h < cell.frame.size(); ++h) {
      const double away = std::abs(WrapAngle(static_cast<double>(h - chosen) * width_rad));
      if (away > kApartRad) rival = std::max(rival, cell.frame(h));
    }
  }
  return rival;
}

}  // namespace

struct Victoria2013Compass::Impl {
  Impl(ColourModel learned,
       calib::MountedCamera camera,
       const ColourCompassParams& wanted,
       PreviousHeading used)
      : model(Checked(std::move(learned))),
        forward(std::move(camera)),
        params((wanted.Validate(), wanted)),
        previous(used),
        limits(LimitsFor(model.bins)),
        classes(model.classes),
        strip(forward),
        newest_s(NewestStamp(model)),
        lines(forward, params.lines) {}

  /// Moves the previous heading by the turn since then.
  void TurnPrevious(const cv::Mat& bgr);
  [[nodiscard]] double WidthRad() const { return 2 * pi / model.bins; }
  /// Score of each heading in a cell. @param placed  Whether the position is known.
  [[nodiscard]] CellScores ScoresOf(const AskedCell& asked, bool placed) const;
  /// diff(f, g), a row per line and a column per bin of the cell; NaN: an empty bin.
  [[nodiscard]] Eigen::MatrixXd DifferencesIn(const Cell& cell) const;
  std::optional<ColourHeading> Answer(const std::vector<AskedCell>& cells, bool placed);

  ColourModel model;
  calib::MountedCamera forward;
  ColourCompassParams params;
  PreviousHeading previous;
  SimilarityLimits limits;
  ColourClasses classes;
  StripTurn strip;
  double newest_s;
  ColourCounts counts;
  ScanLinesByTilt lines;
  std::optional<double> last_s;
  std::optional<double> used_s;  // of the frame whose features are held; unset: it was skipped
  std::optional<double> previous_rad;
  cv::Mat samples;
  LineFeatures features;
  std::vector<CellOrientation> orientations;
};

void Victoria2013Compass::Impl::TurnPrevious(const cv::Mat& bgr) {
  if (previous != PreviousHeading::kTurned) return;
  const std::optional<MeasuredTurn> turned = strip.Next(bgr);
  if (!last_s) return;
  if (!turned) {
    ++counts.without_turn;
    previous_rad.reset();
    return;
  }
  const double scale = 1 / (1 + std::max(0.0, params.camera_ahead_of_axle_m) / model.depth_m);
  if (previous_rad) *previous_rad += scale * turned->turn_rad;
}

Eigen::MatrixXd Victoria2013Compass::Impl::DifferencesIn(const Cell& cell) const {
  Eigen::MatrixXd differences = Eigen::MatrixXd::Constant(
      features.rows(), model.bins, std::numeric_limits<double>::quiet_NaN());
  for (int b = 0; b < model.bins; ++b) {
    const AngleBin& bin = cell.bins[static_cast<std::size_t>(b)];
    if (bin.empty()) continue;
    for (Eigen::Index i = 0; i < features.rows(); ++i) {
      differences(i, b) = FeatureDifference(features.row(i).transpose(), bin.transitions);
    }
  }
  return differences;
}

CellScores Victoria2013Compass::Impl::ScoresOf(const AskedCell& asked, bool placed) const {
  const Cell& cell = model.cells[static_cast<std::size_t>(asked.cell)];
  const Eigen::MatrixXd differences = DifferencesIn(cell);
  const std::vector<double>& azimuths = lines.Latest().Azimuths();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(model.bins);
  CellScores scores{none, none};
  for (int h = 0; h < model.bins; ++h) {
    const double heading = h * WidthRad();
    for (std::size_t i = 0; i < azimuths.size(); ++i) {
      const int b = BinOf(heading + azimuths[i], model.bins);
      const AngleBin& bin = cell.bins[static_cast<std::size_t>(b)];
      if (bin.empty()) continue;
      FeaturePair pair;
      if (placed) pair.distance_m = (asked.place - bin.place).norm();
      pair.difference = differences(static_cast<Eigen::Index>(i), b);
      pair.certainty_1 = asked.share;
      pair.certainty_2 = FadedCertainty(bin, newest_s, model.fading_s);
      scores.frame(h) += Similarity(pair, limits);
      if (previous_rad) pair.angle_rad = std::abs(WrapAngle(heading - *previous_rad));
      scores.full(h) += Similarity(pair, limits);
    }
  }
  return scores;
}

std::optional<ColourHeading> Victoria2013Compass::Impl::Answer(const std::vector<AskedCell>& cells,
                                                               bool placed) {
  std::vector<CellScores> scores;
  std::size_t winner = 0;
  Eigen::Index chosen = 0;
  double top = 0;
  for (const AskedCell& asked : cells) {
    scores.push_back(ScoresOf(asked, placed));
    Eigen::Index h = 0;
    const double score = scores.back().full.maxCoeff(&h);
    orientations.push_back({asked.cell, WrapAngle(static_cast<double>(h) * WidthRad()), score});
    if (score <= top) continue;
    top = score;
    chosen = h;
    winner = scores.size() - 1;
  }
  std::stable_sort(orientations.begin(), orientations.end(), [](const auto& a, const auto& b) {
    return a.score > b.score;
  });
  if (!(top > 0)) return std::nullopt;
  constexpr double kIndependentLines = 5;
  const Eigen::VectorXd& frame = scores[winner].frame;
  ColourHeading heading;
  heading.heading_rad = WrapAngle(static_cast<double>(chosen) * WidthRad());
  heading.variance_rad2 = VarianceAround(frame, chosen, WidthRad());
  heading.confidence = std::max(
      0.0, 1 - std::pow(Rival(scores, chosen, WidthRad()) / frame(chosen), kIndependentLines));
  heading.place = cells[winner].place;
  return heading;
}

Victoria2013Compass::Victoria2013Compass(ColourModel model,
                                         const calib::MountedCamera& forward,
                                         const ColourCompassParams& params,
                                         PreviousHeading previous)
    : impl_(std::make_unique<Impl>(std::move(model), forward, params, previous)) {}
Victoria2013Compass::~Victoria2013Compass() = default;
Victoria2013Compass::Victoria2013Compass(Victoria2013Compass&&) noexcept = default;
Victoria2013Compass& Victoria2013Compass::operator=(Victoria2013Compass&&) noexcept = default;

std::optional<ColourHeading> Victoria2013Compass::Next(const ColourFrame& frame) {
  Impl& me = *impl_;
  if (!std::isfinite(frame.stamp_s) || (me.last_s && frame.stamp_s <= *me.last_s)) {
    throw InputError(fmt::format("stamp {} is not later than the one before", frame.stamp_s));
  }
  const ScanLines& lines = *me.lines.For(frame.tilt);
  me.orientations.clear();
  me.used_s.reset();
  if (!lines.Usable()) {
    me.last_s = frame.stamp_s;
    me.strip.Reset();
    ++me.counts.below_horizon;
    return std::nullopt;
  }
  lines.Sample(frame.bgr, me.samples);
  me.TurnPrevious(frame.bgr);
  me.last_s = me.used_s = frame.stamp_s;
  CountTransitions(me.samples, lines, me.classes, me.features);
  ++me.counts.used;
  const bool placed = !frame.places.empty();
  auto heading = me.Answer(
      placed ? AskedCells(me.model, frame.places, kMinCellShare) : AllLearned(me.model), placed);
  if (heading && me.previous != PreviousHeading::kNone) {
    me.previous_rad = heading->heading_rad;
  }
  return heading;
}

void Victoria2013Compass::Learn(const LearnedPose& pose) {
  Impl& me = *impl_;
  if (!me.used_s) return;
  Replace(me.features, me.lines.Latest().Azimuths(), *me.used_s, pose, me.model);
  me.newest_s = std::max(me.newest_s, *me.used_s);
}

void Victoria2013Compass::Reset() {
  Impl& me = *impl_;
  me.previous_rad.reset();
  me.strip.Reset();
  me.last_s.reset();
  me.used_s.reset();
  me.orientations.clear();
}

const ColourModel& Victoria2013Compass::Model() const {
  return impl_->model;
}

const ColourCounts& Victoria2013Compass::Counts() const {
  return impl_->counts;
}

std::span<const CellOrientation> Victoria2013Compass::Orientations() const {
  return impl_->orientations;
}

}  // namespace ceilmap::colour
