#include "mapping/loop_closer.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>

#include "calib/error.hpp"
#include "calib/level_view.hpp"
#include "mapping/keyframe_headings.hpp"
#include "mapping/place_descriptor.hpp"
#include "mapping/place_index.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/recently_used.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registrar;
using registration::Registration;
using registration::Verdict;

void LoopCloserParams::Validate() const {
  const auto require = [](bool good, const char* field, double value, const char* range) {
    if (!good) {
      throw calib::InputError(
          fmt::format("loop closing: {} = {}, must be {}", field, value, range));
    }
  };
  require(min_overlap > 0 && min_overlap < 1, "min_overlap", min_overlap, "in (0, 1)");
  require(comparisons_per_keyframe >= 0,
          "comparisons_per_keyframe",
          comparisons_per_keyframe,
          "at least 0");
  require(closures_per_keyframe >= 0, "closures_per_keyframe", closures_per_keyframe, "at least 0");
  require(min_gain >= 0, "min_gain", min_gain, ">= 0");
  require(max_sigmas > 0, "max_sigmas", max_sigmas, "> 0");
  require(floor_px > 0, "floor_px", floor_px, "> 0");
  require(floor_rad > 0, "floor_rad", floor_rad, "> 0");
  require(confirm_px > 0, "confirm_px", confirm_px, "> 0");
  require(max_rival_part > 0 && max_rival_part <= 1, "max_rival_part", max_rival_part, "in (0, 1]");
  require(max_contradicting_part >= 0, "max_contradicting_part", max_contradicting_part, ">= 0");
  require(confirm_within >= 1, "confirm_within", confirm_within, "at least 1");
  require(looks_sigma_part > 0, "looks_sigma_part", looks_sigma_part, "> 0");
  require(looks_gap >= 1, "looks_gap", looks_gap, "at least 1");
  require(window >= 1, "window", window, "at least 1");
  require(cached_spectra >= 2, "cached_spectra", cached_spectra, "at least 2");
  heading.Validate();
}

namespace {

double LargestSigma(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

/// Keyframe that might be seen again.
struct LoopCandidate {
  std::int64_t id = 0;
  double overlap = 0;
};

/// A closure that no other one supports yet.
struct Pending {
  Edge edge;
  std::int64_t keyframe = 0;  // that brought it
};

}  // namespace

struct LoopCloser::Impl {
  Impl(const calib::CeilingView& ceiling_view, PictureLoader loader, const LoopCloserParams& p)
      : view(ceiling_view),
        load(std::move(loader)),
        params(p),
        registrar(view.Size(), p.registration),
        span(std::max(view.Size().width, view.Size().height) * view.MetresPerPixel()),
        graph(span, 0.5 * span),
        headings(p.heading),
        spectra(static_cast<std::size_t>(p.cached_spectra)),
        places(PlaceDescriber::Dimension()) {}

  using Relative = KeyframeGraph::Relative;

  const calib::CeilingView& view;
  PictureLoader load;
  LoopCloserParams params;
  Registrar registrar;
  double span;  // map units across the picture's longer side
  KeyframeGraph graph;
  KeyframeHeadings headings;
  RecentlyUsed<FrameSpectrum> spectra;
  PlaceIndex places;
  std::int64_t latest_id = -1;              // keyframe that was added last ...
  cv::Mat latest_descriptors;               // ... and what it looks like
  std::vector<Pose2> recorded;              // by id: the pose that the keyframe came with
  std::vector<Eigen::Matrix3d> covariance;  // by id: of the pose, by the best path from the start
  std::vector<Pending> pending;
  LoopCounts counts;

  FrameSpectrum Spectrum(std::int64_t id);
  double Overlap(const Pose2& T_from_to) const;
  Edge ClosureEdge(const Registration& measured, std::int64_t from, std::int64_t to) const;
  MotionPrior Prior(const Pose2& T_from_to, double sigma, double sigma_rad) const;
  std::vector<LoopCandidate> Candidates(std::int64_t id) const;
  std::vector<LoopCandidate> Around(std::int64_t id, double sigma) const;
  std::vector<LoopCandidate> Alike(std::int64_t id) const;
  bool WorthWhile(const Relative& predicted, std::int64_t id) const;
  bool Agrees(const Edge& edge, const Relative& predicted) const;
  std::optional<Edge> Measure(std::int64_t from,
                              std::int64_t to,
                              const Relative& predicted,
                              bool doubtful);
  bool Consistent(const Edge& known, const Edge& edge) const;
  bool Confirm(const Edge& edge, std::int64_t keyframe);
  void Accept(const Edge& edge);
  void MoveWindow(std::int64_t latest);
};

FrameSpectrum LoopCloser::Impl::Spectrum(std::int64_t id) {
  if (const FrameSpectrum* kept = spectra.Find(id)) return *kept;
  const cv::Mat picture = load(id);
  FrameSpectrum spectrum = registrar.Analyze(picture, calib::ContentMask(picture));
  spectra.Insert(id, spectrum);
  return spectrum;
}

double LoopCloser::Impl::Overlap(const Pose2& T_from_to) const {
  return registration::OverlapOf(ImageMotionOf(view, T_from_to), view.Size());
}

/// Keyframes that a measured motion ties to this one already, and itself.
std::unordered_set<std::int64_t> Tied(const KeyframeGraph& graph, std::int64_t id) {
  std::unordered_set<std::int64_t> tied = {id};
  for (const std::size_t e : graph.EdgesOf(id)) {
    tied.insert(graph.Edges()[e].from);
    tied.insert(graph.Edges()[e].to);
  }
  return tied;
}

std::vector<LoopCandidate> LoopCloser::Impl::Candidates(std::int64_t id) const {
  const auto index = static_cast<std::size_t>(id);
  const double sigma = LargestSigma(covariance[index].topLeftCorner<2, 2>());
  return sigma < params.looks_sigma_part * span ? Around(id, sigma) : Alike(id);
}

/// Most overlap first.
std::vector<LoopCandidate> LoopCloser::Impl::Around(std::int64_t id, double sigma) const {
  const Pose2& T_map_base = graph.T_map_base(id);
  // Where the camera stands off the base, a turn moves the picture against the base.
  const double radius = (1 - params.min_overlap) * 1.25 * span +
                        2 * view.T_base_view().Translation().norm() + 3 * sigma;
  const std::unordered_set<std::int64_t> tied = Tied(graph, id);
  std::vector<LoopCandidate> candidates;
  for (const std::int64_t other : graph.Near(T_map_base.Translation(), radius)) {
    if (tied.contains(other)) continue;
    const double overlap = Overlap(graph.T_map_base(other).Inverse() * T_map_base);
    if (overlap + 3 * sigma / span >= params.min_overlap) candidates.push_back({other, overlap});
  }
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const LoopCandidate& a, const LoopCandidate& b) {
        return a.overlap > b.overlap;
      });
  constexpr std::size_t kMost = 24;
  if (candidates.size() > kMost) candidates.resize(kMost);
  return candidates;
}

/// Most alike first. The latest keyframes look alike too, but close no loop.
std::vector<LoopCandidate> LoopCloser::Impl::Alike(std::int64_t id) const {
  if (id != latest_id) return {};
  const std::unordered_set<std::int64_t> tied = Tied(graph, id);
  std::vector<LoopCandidate> candidates;
  for (const PlaceIndex::Match& match :
       places.Search(latest_descriptors, params.comparisons_per_keyframe, [&](std::int64_t other) {
         return tied.contains(other) || (other < id && other + params.looks_gap > id);
       })) {
    candidates.push_back({match.keyframe_id, 0});
  }
  return candidates;
}

MotionPrior LoopCloser::Impl::Prior(const Pose2& T_from_to, double sigma, double sigma_rad) const {
  MotionPrior prior;
  prior.motion = ImageMotionOf(view, T_from_to);
  prior.sigma_px = std::max(2.0, sigma / view.MetresPerPixel());
  prior.sigma_theta_rad = std::max(0.01, sigma_rad);
  return prior;
}

Edge LoopCloser::Impl::ClosureEdge(const Registration& measured,
                                   std::int64_t from,
                                   std::int64_t to) const {
  Edge edge = MeasuredEdge(view, measured, from, to, params.noise);
  edge.kind = Edge::Kind::kLoopClosure;
  return edge;
}

/// Is the motion known worse than one measurement would tell? The keyframe's own tie stands for a
/// measurement.
bool LoopCloser::Impl::WorthWhile(const Relative& predicted, std::int64_t id) const {
  if (graph.EdgesOf(id).empty()) return true;
  const auto variance = [this](const Eigen::Matrix3d& c) {
    return c(0, 0) + c(1, 1) + 0.25 * span * span * c(2, 2);
  };
  const Edge& tie = graph.Edges()[graph.EdgesOf(id).front()];
  return variance(predicted.covariance) > params.min_gain * variance(tie.information.inverse());
}

bool LoopCloser::Impl::Agrees(const Edge& edge, const Relative& predicted) const {
  const Pose2 off = predicted.T_from_to.Inverse() * edge.T_from_to;
  Eigen::Matrix3d spread = predicted.covariance + edge.information.inverse();
  const double floor = params.floor_px * view.MetresPerPixel();
  spread.diagonal() +=
      Eigen::Vector3d(floor * floor, floor * floor, params.floor_rad * params.floor_rad);
  // `off` is expressed in the predicted `to` frame, the covariance in `from`.
  const Eigen::Vector2d t = predicted.T_from_to.Rotation() * off.Translation();
  const Eigen::Vector3d difference(t.x(), t.y(), off.yaw);
  return difference.dot(spread.ldlt().solve(difference)) < params.max_sigmas * params.max_sigmas;
}

std::optional<Edge> LoopCloser::Impl::Measure(std::int64_t from,
                                              std::int64_t to,
                                              const Relative& predicted,
                                              bool doubtful) {
  ++counts.compared;
  const MotionPrior prior = Prior(predicted.T_from_to,
                                  LargestSigma(predicted.covariance.topLeftCorner<2, 2>()),
                                  std::sqrt(predicted.covariance(2, 2)));
  const Registration measured = registrar.Register(Spectrum(from), Spectrum(to), prior);
  if (measured.verdict == Verdict::kAmbiguous) ++counts.ambiguous;
  if (!measured.ok()) {
    if (measured.verdict != Verdict::kAmbiguous) ++counts.no_match;
    return std::nullopt;
  }
  const bool rivalled =
      measured.by_prior || measured.runner_up > params.max_rival_part * measured.peak;
  if (doubtful && rivalled) {
    ++counts.ambiguous;
    return std::nullopt;
  }
  const Edge edge = ClosureEdge(measured, from, to);
  if (!Agrees(edge, predicted)) {
    ++counts.off_prediction;
    return std::nullopt;
  }
  return edge;
}

/// Do two closures say the same of how the old part of the path lies to the new one?
bool LoopCloser::Impl::Consistent(const Edge& known, const Edge& edge) const {
  const std::vector<std::int64_t> old_target = {known.from};
  const std::vector<std::int64_t> new_target = {edge.to};
  const auto old_part = graph.RelativeTo(edge.from, old_target);
  const auto new_part = graph.RelativeTo(known.to, new_target);
  if (old_part.empty() || new_part.empty()) return false;
  // edge.from -> known.from -> known.to -> edge.to
  const Relative& first = old_part.begin()->second;
  const Relative& last = new_part.begin()->second;
  Relative around;
  around.covariance = ComposeCovariance(
      first.T_from_to, first.covariance, known.T_from_to, known.information.inverse());
  around.T_from_to = first.T_from_to * known.T_from_to;
  around.covariance =
      ComposeCovariance(around.T_from_to, around.covariance, last.T_from_to, last.covariance);
  around.T_from_to = around.T_from_to * last.T_from_to;
  return Agrees(edge, around);
}

/// True when closures of other new pictures support this one and few contradict it; those that
/// waited for it are accepted. On a ceiling that repeats itself a place is found in several places
/// at once.
bool LoopCloser::Impl::Confirm(const Edge& edge, std::int64_t keyframe) {
  const auto agreeing = std::stable_partition(
      pending.begin(), pending.end(), [&](const Pending& p) { return !Consistent(p.edge, edge); });
  const auto contradicting = static_cast<double>(agreeing - pending.begin());
  const auto supporting = static_cast<double>(std::count_if(
      agreeing, pending.end(), [&](const Pending& p) { return p.edge.to != edge.to; }));
  if (supporting == 0 || contradicting > params.max_contradicting_part * supporting) {
    pending.push_back({edge, keyframe});
    return false;
  }
  const std::vector<Pending> confirmed(agreeing, pending.end());
  pending.erase(agreeing, pending.end());
  for (const Pending& waited : confirmed) Accept(waited.edge);
  return true;
}

void LoopCloser::Impl::Accept(const Edge& edge) {
  graph.Add(edge);
  ++counts.accepted;
  // The newer keyframe is known at least as well as the older one and the closure.
  const auto from = static_cast<std::size_t>(edge.from);
  const auto to = static_cast<std::size_t>(edge.to);
  const Eigen::Matrix3d through = ComposeCovariance(
      graph.T_map_base(edge.from), covariance[from], edge.T_from_to, edge.information.inverse());
  if (through.topLeftCorner<2, 2>().trace() < covariance[to].topLeftCorner<2, 2>().trace()) {
    covariance[to] = through;
  }
}

/// The latest keyframes go where the closures say, everything older stays: bounded work. What the
/// old part has to give is left to the full optimisation at the end.
void LoopCloser::Impl::MoveWindow(std::int64_t latest) {
  const std::int64_t oldest = std::max<std::int64_t>(0, latest - params.window + 1);
  std::vector<Edge> edges;
  std::unordered_set<std::int64_t> held;
  for (std::int64_t id = oldest; id <= latest; ++id) {
    if (!graph.Has(id)) continue;
    for (const std::size_t e : graph.EdgesOf(id)) {
      const Edge& edge = graph.Edges()[e];
      const std::int64_t other = edge.from == id ? edge.to : edge.from;
      const bool inside = other >= oldest && other <= latest;
      if (!inside) held.insert(other);
      if (!inside || other > id) edges.push_back(edge);
    }
  }
  if (held.empty()) return;
  const std::vector<std::int64_t> fixed(held.begin(), held.end());
  std::vector<Pose2> poses = graph.Poses();
  PoseGraphParams pose_graph;
  pose_graph.threads = 1;
  pose_graph.max_iterations = 10;
  OptimizePoses(edges, fixed, poses, pose_graph);
  for (std::int64_t id = oldest; id <= latest; ++id) {
    if (graph.Has(id)) graph.Move(id, poses[static_cast<std::size_t>(id)]);
  }
}

LoopCloser::LoopCloser(const calib::CeilingView& view,
                       PictureLoader load,
                       const LoopCloserParams& params) {
  params.Validate();
  impl_ = std::make_unique<Impl>(view, std::move(load), params);
}
LoopCloser::~LoopCloser() = default;

void LoopCloser::Add(const Keyframe& keyframe,
                     const FrameSpectrum& spectrum,
                     std::span<const Edge> edges,
                     const cv::Mat& descriptors) {
  Impl& me = *impl_;
  const auto index = static_cast<std::size_t>(keyframe.id);
  Pose2 T_map_base = keyframe.pose.T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (!edges.empty()) {
    // What loop closing has moved takes along what comes after it.
    const Edge& tie = edges.front();
    const auto from = static_cast<std::size_t>(tie.from);
    T_map_base =
        me.graph.T_map_base(tie.from) * (me.recorded[from].Inverse() * keyframe.pose.T_map_base);
    covariance = ComposeCovariance(me.graph.T_map_base(tie.from),
                                   me.covariance[from],
                                   tie.T_from_to,
                                   tie.information.inverse());
  }
  me.graph.Add(keyframe.id, T_map_base);
  if (index >= me.recorded.size()) {
    me.recorded.resize(index + 1);
    me.covariance.resize(index + 1, Eigen::Matrix3d::Zero());
  }
  me.recorded[index] = keyframe.pose.T_map_base;
  me.covariance[index] = covariance;
  for (const Edge& edge : edges) me.graph.Add(edge);
  if (keyframe.pose.heading) me.headings.Add(keyframe.id, *keyframe.pose.heading);
  if (!spectrum.empty()) me.spectra.Insert(keyframe.id, spectrum);
  if (!descriptors.empty()) {
    me.places.Add(keyframe.id, descriptors);
    me.latest_id = keyframe.id;
    me.latest_descriptors = descriptors;
  }
}

void LoopCloser::Add(const Edge& edge) {
  impl_->graph.Add(edge);
}

void LoopCloser::Close(std::int64_t id) {
  Impl& me = *impl_;
  const LoopCloserParams& params = me.params;
  std::erase_if(me.pending, [&](const Pending& waiting) {
    const bool over = waiting.keyframe + params.confirm_within < id;
    if (over) ++me.counts.unconfirmed;
    return over;
  });
  const std::int64_t accepted_before = me.counts.accepted;
  int compared = 0;
  for (const LoopCandidate& candidate : me.Candidates(id)) {
    if (compared >= params.comparisons_per_keyframe) break;
    if (me.counts.accepted - accepted_before >= params.closures_per_keyframe) break;
    // Anew each time: a closure found a moment ago makes its neighbours needless.
    const std::vector<std::int64_t> target = {id};
    const auto relative = me.graph.RelativeTo(candidate.id, target);
    if (relative.empty()) continue;  // another segment
    const KeyframeGraph::Relative predicted =
        me.headings.Narrowed(relative.begin()->second, candidate.id, id);
    const double doubt_px =
        LargestSigma(predicted.covariance.topLeftCorner<2, 2>()) / me.view.MetresPerPixel();
    const bool doubtful = doubt_px > params.confirm_px;
    if (!me.WorthWhile(predicted, id)) continue;
    if (!doubtful && me.Overlap(predicted.T_from_to) < params.min_overlap) continue;
    ++compared;
    const std::optional<Edge> edge = me.Measure(candidate.id, id, predicted, doubtful);
    if (edge && (!doubtful || me.Confirm(*edge, id))) me.Accept(*edge);
  }
  if (me.counts.accepted > accepted_before) me.MoveWindow(id);
}

Registration LoopCloser::Compare(std::int64_t from,
                                 std::int64_t to,
                                 const std::optional<MotionPrior>& prior) {
  return impl_->registrar.Register(impl_->Spectrum(from), impl_->Spectrum(to), prior);
}

MotionPrior LoopCloser::Prior(const Pose2& T_from_to, double sigma, double sigma_rad) const {
  return impl_->Prior(T_from_to, sigma, sigma_rad);
}
std::optional<MotionPrior> LoopCloser::CompassPrior(std::int64_t from, std::int64_t to) const {
  const auto turn = impl_->headings.Turn(from, to);
  if (!turn) return std::nullopt;
  constexpr double kAnywhere = 10;  // spans
  return impl_->Prior(
      {0, 0, turn->turn_rad}, kAnywhere * impl_->span, std::sqrt(turn->variance_rad2));
}
bool LoopCloser::ContradictsCompass(const Edge& edge) const {
  return impl_->headings.Contradict(edge);
}
Edge LoopCloser::ClosureEdge(const Registration& measured,
                             std::int64_t from,
                             std::int64_t to) const {
  return impl_->ClosureEdge(measured, from, to);
}
double LoopCloser::Overlap(const Pose2& T_from_to) const {
  return impl_->Overlap(T_from_to);
}
double LoopCloser::Span() const {
  return impl_->span;
}
const KeyframeGraph& LoopCloser::Graph() const {
  return impl_->graph;
}
KeyframeGraph& LoopCloser::Graph() {
  return impl_->graph;
}

LoopCounts LoopCloser::Counts() const {
  LoopCounts counts = impl_->counts;
  counts.unconfirmed += static_cast<std::int64_t>(impl_->pending.size());
  return counts;
}

}  // namespace ceilmap::mapping
