#include "mapping/loop_closer.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "calib/base/field_check.hpp"
#include "calib/base/lru_cache.hpp"
#include "calib/base/pose_with_covariance.hpp"
#include "calib/level_view.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/keyframe_headings.hpp"

namespace ceilmap::mapping {

namespace {

// A closure is searched for only where the variance of the predicted motion exceeds this
// multiple of the variance of one measurement. Other closures cost time and add no information.
constexpr double kMinGain = 2;
// Where the standard deviation of the prediction exceeds this value, a closure waits until a
// closure of another new image confirms it (LoopVerifier::Confirm).
constexpr double kConfirmPx = 12;
// ... and it is rejected as ambiguous when another motion of the images reaches this fraction of
// the best motion's agreement.
constexpr double kMaxRivalRatio = 0.7;
constexpr int kWindow = 30;  // number of latest keyframes that are moved when a closure is found
constexpr std::size_t kCachedImages = 40;     // 0.3 MB each for images of 640 x 480
constexpr std::size_t kCachedSpectra = 12;    // 2 MB
constexpr std::size_t kCachedReferences = 4;  // of these, as references: 3 MB more

}  // namespace

using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registrar;
using registration::Registration;
using registration::Verdict;

void LoopCloserParams::Validate() const {
  candidates.Validate();
  judge.Validate();
  const FieldCheck require("loop closing");
  require(comparisons_per_keyframe >= 0,
          "comparisons_per_keyframe",
          comparisons_per_keyframe,
          "at least 0");
  require(closures_per_keyframe >= 0, "closures_per_keyframe", closures_per_keyframe, "at least 0");
  heading.Validate();
}

namespace {

double LargestSigma(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

}  // namespace

struct LoopCloser::Impl {
  Impl(const calib::CeilingView& ceiling_view, graph::ImageLoader loader, const LoopCloserParams& p)
      : view(ceiling_view),
        load(std::move(loader)),
        params(p),
        registrar(view.Size(), p.registration),
        span(SpanOf(view)),
        graph(span, 0.5 * span),
        headings(p.heading),
        images(kCachedImages),
        spectra(kCachedSpectra),
        candidates(view, p.candidates),
        judge(view.MetresPerPixel(), p.judge) {}

  using Relative = graph::KeyframeGraph::Relative;

  const calib::CeilingView& view;
  graph::ImageLoader load;
  LoopCloserParams params;
  Registrar registrar;
  std::unordered_set<std::int64_t> starved;  // keyframes without closures (IsStarved)
  double span;                               // map units across the image's longer side
  graph::KeyframeGraph graph;
  KeyframeHeadings headings;
  LruCache<cv::Mat> images;
  LruCache<FrameSpectrum> spectra;
  std::unordered_map<std::int64_t, registration::Encoding> encodings;  // of all images
  std::unordered_map<std::int64_t, std::shared_ptr<const heights::HeightField>> heights;
  LoopCandidates candidates;
  LoopVerifier judge;
  std::vector<std::int64_t> by_wheels;  // keyframes that only the wheels tie to those before
  std::vector<Pose2> recorded;          // by id: pose of the keyframe when it was added
  // By id: covariance of the pose, along the best path from the start
  std::vector<Eigen::Matrix3d> covariance;
  graph::LoopCounts counts;

  FrameSpectrum Spectrum(std::int64_t id);
  graph::Edge ClosureEdge(const Registration& measured, std::int64_t from, std::int64_t to) const;
  MotionPrior Prior(const Pose2& T_from_to, double sigma, double sigma_rad) const;
  bool WorthWhile(const Relative& predicted, std::int64_t id) const;
  bool MayHaveSlipped(std::int64_t from, std::int64_t to) const;
  std::vector<graph::Edge> Measure(std::int64_t from,
                                   std::int64_t to,
                                   const Relative& predicted,
                                   bool uncertain);
  void Accept(const graph::Edge& edge);
  void MoveWindow(std::int64_t latest);
};

FrameSpectrum LoopCloser::Impl::Spectrum(std::int64_t id) {
  FrameSpectrum spectrum;
  if (const FrameSpectrum* kept = spectra.Find(id)) {
    spectrum = *kept;
  } else {
    cv::Mat image;
    if (const cv::Mat* const kept_image = images.Find(id)) {
      image = *kept_image;
    } else {
      image = load(id);
      images.Insert(id, image);
    }
    spectrum = registrar.Analyze(image, calib::ContentMask(image), encodings[id]);
    spectra.Insert(id, spectrum);
  }
  const auto known = heights.find(id);
  if (known != heights.end()) spectrum.SetHeights(known->second);
  return spectrum;
}

MotionPrior LoopCloser::Impl::Prior(const Pose2& T_from_to, double sigma, double sigma_rad) const {
  MotionPrior prior;
  prior.motion = ImageMotionOf(view, T_from_to);
  prior.sigma_px = std::max(2.0, sigma / view.MetresPerPixel());
  prior.sigma_theta_rad = std::max(0.01, sigma_rad);
  return prior;
}

graph::Edge LoopCloser::Impl::ClosureEdge(const Registration& measured,
                                          std::int64_t from,
                                          std::int64_t to) const {
  graph::Edge edge = MeasuredEdge(view, measured, from, to, params.noise);
  edge.kind = graph::Edge::Kind::kLoopClosure;
  return edge;
}

/// Whether a measurement would add information: the predicted motion is less certain than one
/// measurement. The keyframe's own odometry edge represents a measurement.
bool LoopCloser::Impl::WorthWhile(const Relative& predicted, std::int64_t id) const {
  if (graph.EdgesOf(id).empty()) return true;
  const auto variance = [this](const Eigen::Matrix3d& c) {
    return c(0, 0) + c(1, 1) + 0.25 * span * span * c(2, 2);
  };
  const graph::Edge& tie = graph.Edges()[graph.EdgesOf(id).front()];
  return variance(predicted.covariance) > kMinGain * variance(tie.information.inverse());
}

/// Whether the way between two keyframes leads over a stretch that only the wheels know. In the
/// dark nothing tells a slip of the wheels.
bool LoopCloser::Impl::MayHaveSlipped(std::int64_t from, std::int64_t to) const {
  const auto first = std::upper_bound(by_wheels.begin(), by_wheels.end(), std::min(from, to));
  return first != by_wheels.end() && *first <= std::max(from, to);
}

/// The closures that are certain with this comparison: none, its own, or also those that waited for
/// it.
std::vector<graph::Edge> LoopCloser::Impl::Measure(std::int64_t from,
                                                   std::int64_t to,
                                                   const Relative& predicted,
                                                   bool uncertain) {
  ++counts.compared;
  const MotionPrior prior = Prior(predicted.T_from_to,
                                  LargestSigma(predicted.covariance.topLeftCorner<2, 2>()),
                                  std::sqrt(predicted.covariance(2, 2)));
  const Registration measured = registrar.Register(Spectrum(from), Spectrum(to), prior);
  if (measured.verdict == Verdict::kAmbiguous) ++counts.ambiguous;
  if (!measured.ok()) {
    if (measured.verdict != Verdict::kAmbiguous) ++counts.no_match;
    return {};
  }
  const bool rivalled =
      measured.disambiguated_by_prior || measured.runner_up > kMaxRivalRatio * measured.peak;
  if (uncertain && rivalled) {
    ++counts.ambiguous;
    return {};
  }
  const graph::Edge edge = ClosureEdge(measured, from, to);
  const bool as_predicted = judge.Agrees(edge, predicted);
  if (!as_predicted && (rivalled || !MayHaveSlipped(from, to))) {
    ++counts.off_prediction;
    return {};
  }
  if (as_predicted && !uncertain) return {edge};
  return judge.Confirm(edge, graph);
}

void LoopCloser::Impl::Accept(const graph::Edge& edge) {
  graph.Add(edge);
  ++counts.accepted;
  // Afterwards the newer keyframe is at least as certain as the older one and the closure together.
  const auto from = static_cast<std::size_t>(edge.from);
  const auto to = static_cast<std::size_t>(edge.to);
  const Eigen::Matrix3d through = ComposeCovariance(
      graph.T_map_base(edge.from), covariance[from], edge.T_from_to, edge.information.inverse());
  if (through.topLeftCorner<2, 2>().trace() < covariance[to].topLeftCorner<2, 2>().trace()) {
    covariance[to] = through;
  }
}

/// Optimizes the latest keyframes with the closures and keeps all older ones fixed: bounded work.
/// Corrections of the older part are left to the full optimization at the end.
void LoopCloser::Impl::MoveWindow(std::int64_t latest) {
  const std::int64_t oldest = std::max<std::int64_t>(0, latest - kWindow + 1);
  std::vector<graph::Edge> edges;
  std::unordered_set<std::int64_t> held;
  for (std::int64_t id = oldest; id <= latest; ++id) {
    if (!graph.Has(id)) continue;
    for (const std::size_t e : graph.EdgesOf(id)) {
      const graph::Edge& edge = graph.Edges()[e];
      const std::int64_t other = edge.from == id ? edge.to : edge.from;
      const bool inside = other >= oldest && other <= latest;
      if (!inside) held.insert(other);
      if (!inside || other > id) edges.push_back(edge);
    }
  }
  if (held.empty()) return;
  const std::vector<std::int64_t> fixed(held.begin(), held.end());
  std::vector<Pose2> poses = graph.Poses();
  graph::PoseGraphParams pose_graph;
  pose_graph.threads = 1;
  pose_graph.max_iterations = 10;
  graph::OptimizePoses(edges, fixed, poses, pose_graph);
  for (std::int64_t id = oldest; id <= latest; ++id) {
    if (graph.Has(id)) graph.Move(id, poses[static_cast<std::size_t>(id)]);
  }
}

LoopCloser::LoopCloser(const calib::CeilingView& view,
                       graph::ImageLoader load,
                       const LoopCloserParams& params) {
  params.Validate();
  impl_ = std::make_unique<Impl>(view, std::move(load), params);
}
LoopCloser::~LoopCloser() = default;

void LoopCloser::Add(const graph::Keyframe& keyframe,
                     const FrameSpectrum& spectrum,
                     std::span<const graph::Edge> edges,
                     const cv::Mat& descriptors) {
  Impl& me = *impl_;
  const auto index = static_cast<std::size_t>(keyframe.id);
  Pose2 T_map_base = keyframe.pose.T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (!edges.empty()) {
    // A correction by loop closing also applies to the keyframes that come after it.
    const graph::Edge& tie = edges.front();
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
  for (const graph::Edge& edge : edges) me.graph.Add(edge);
  if (!edges.empty() && edges.front().kind == graph::Edge::Kind::kWheels) {
    me.by_wheels.push_back(keyframe.id);
  }
  if (keyframe.pose.heading) me.headings.Add(keyframe.id, *keyframe.pose.heading);
  if (!keyframe.image.empty()) me.images.Insert(keyframe.id, keyframe.image);
  if (!spectrum.empty()) {
    me.spectra.Insert(keyframe.id, spectrum);
    me.encodings[keyframe.id] = spectrum.GetEncoding();
  }
  if (keyframe.heights) me.heights[keyframe.id] = keyframe.heights;
  if (spectrum.IsStarved()) {
    me.starved.insert(keyframe.id);
    return;
  }
  if (!descriptors.empty()) me.candidates.Add(keyframe.id, descriptors);
}

void LoopCloser::SetHeights(std::int64_t id, std::shared_ptr<const heights::HeightField> heights) {
  Impl& me = *impl_;
  me.heights[id] = std::move(heights);
  std::vector<graph::Edge> back;
  for (const std::size_t e : me.graph.EdgesOf(id)) {
    const graph::Edge& edge = me.graph.Edges()[e];
    if (edge.to != id || edge.from > id) continue;
    const std::vector<std::int64_t> target = {edge.from};
    const auto relative = me.graph.RelativeTo(id, target);
    if (relative.empty()) continue;
    MotionPrior prior = me.Prior(relative.begin()->second.T_from_to, 0, 0);
    const Registration measured =
        me.registrar.Register(me.Spectrum(id), me.Spectrum(edge.from), prior);
    if (!measured.ok()) continue;
    const graph::Edge reverse = MeasuredEdge(me.view, measured, id, edge.from, me.params.noise);
    if (!me.judge.Agrees(reverse, relative.begin()->second)) continue;
    back.push_back(reverse);
  }
  for (const graph::Edge& edge : back) me.graph.Add(edge);
}

void LoopCloser::Add(const graph::Edge& edge) {
  impl_->graph.Add(edge);
}

void LoopCloser::Close(std::int64_t id) {
  Impl& me = *impl_;
  me.spectra.ForEachBut(kCachedReferences,
                        [](FrameSpectrum& spectrum) { spectrum.ReleaseBlocks(); });
  const LoopCloserParams& params = me.params;
  me.counts.unconfirmed += me.judge.Forget(id);
  const std::int64_t accepted_before = me.counts.accepted;
  if (me.starved.contains(id)) return;
  int compared = 0;
  const Eigen::Matrix3d& covariance = me.covariance[static_cast<std::size_t>(id)];
  for (const std::int64_t candidate :
       me.candidates.Find(id,
                          LargestSigma(covariance.topLeftCorner<2, 2>()),
                          me.graph,
                          params.comparisons_per_keyframe)) {
    if (compared >= params.comparisons_per_keyframe) break;
    if (me.counts.accepted - accepted_before >= params.closures_per_keyframe) break;
    if (me.starved.contains(candidate)) continue;
    // Predicted anew each time: a closure just found makes those to its neighbours unnecessary.
    const std::vector<std::int64_t> target = {id};
    const auto relative = me.graph.RelativeTo(candidate, target);
    if (relative.empty()) continue;  // another segment
    const graph::KeyframeGraph::Relative predicted =
        me.headings.Narrowed(relative.begin()->second, candidate, id);
    const double sigma_px =
        LargestSigma(predicted.covariance.topLeftCorner<2, 2>()) / me.view.MetresPerPixel();
    const bool uncertain = sigma_px > kConfirmPx;
    if (!me.WorthWhile(predicted, id)) continue;
    const double overlap = OverlapOf(me.view, predicted.T_from_to);
    if (!uncertain && overlap < params.candidates.min_overlap) continue;
    ++compared;
    const auto accepted = me.Measure(candidate, id, predicted, uncertain);
    for (const graph::Edge& closure : accepted) me.Accept(closure);
  }
  if (me.counts.accepted > accepted_before) me.MoveWindow(id);
}

Registration LoopCloser::Compare(std::int64_t from,
                                 std::int64_t to,
                                 const std::optional<MotionPrior>& prior) {
  return impl_->registrar.Register(impl_->Spectrum(from), impl_->Spectrum(to), prior);
}

registration::Dissimilarity LoopCloser::DissimilarityOf(std::int64_t from,
                                                        std::int64_t to,
                                                        const registration::ImageMotion& motion) {
  return impl_->registrar.Compare(impl_->Spectrum(from), impl_->Spectrum(to), motion);
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
bool LoopCloser::ContradictsCompass(const graph::Edge& edge) const {
  return impl_->headings.Contradict(edge);
}
graph::Edge LoopCloser::ClosureEdge(const Registration& measured,
                                    std::int64_t from,
                                    std::int64_t to) const {
  return impl_->ClosureEdge(measured, from, to);
}
double LoopCloser::Overlap(const Pose2& T_from_to) const {
  return OverlapOf(impl_->view, T_from_to);
}
double LoopCloser::Span() const {
  return impl_->span;
}
const graph::KeyframeGraph& LoopCloser::Graph() const {
  return impl_->graph;
}
graph::KeyframeGraph& LoopCloser::Graph() {
  return impl_->graph;
}

graph::LoopCounts LoopCloser::Counts() const {
  graph::LoopCounts counts = impl_->counts;
  counts.unconfirmed += static_cast<std::int64_t>(impl_->judge.Waiting());
  return counts;
}

}  // namespace ceilmap::mapping
