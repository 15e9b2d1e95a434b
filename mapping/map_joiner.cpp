#include "mapping/map_joiner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>

#include "mapping/match_gate.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/places/place_index.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

using registration::MotionPrior;
using registration::Registration;
using registration::Verdict;

namespace {

constexpr int kCandidatesPerKeyframe = 6;  // retrieval candidates that a keyframe is compared with
// Largest number of registrations without a prior of the parts' relative pose.
constexpr int kMaxComparisons = 4000;
// Required number of keyframes of the second part that are recognized independently, ...
constexpr int kMinMatches = 3;
// ... and their required fraction of the keyframes that should be recognized under the parts'
// relative pose.
constexpr double kMinMatchRatio = 0.5;
// Another relative pose that is confirmed by this fraction of the best one's matches makes both
// ambiguous.
constexpr double kRivalRatio = 0.5;
// ... unless this fraction of the best one's matches is unique without a prior, and few of its own.
constexpr double kMinUniqueRatio = 0.8;
// Required fraction of the matches that is unique without a prior, for parts of other recordings.
constexpr double kMinDistinctRatio = 0.25;
// Their required peak, relative to that of neighbours within each part. In a hall with a lattice of
// tiles and lamps 13 true positions had 0.88 and more, also at night and with other cameras; the
// best false ones of seven pairs of maps had 0.71 to 0.75.
constexpr double kMinNeighbourPeakRatio = 0.82;
// Under a ceiling with depth images of one place from two sides agree less well than neighbours do:
// there a lower peak is sufficient where nearly all keyframes that should be recognized are, and at
// only one position.
constexpr int kMinDepthMatches = 6;
constexpr double kMinDepthRatio = 0.8;
constexpr double kMinDepthPeakRatio = 0.6;
constexpr int kMaxChecks = 40;  // largest number of keyframes that test a relative pose
// Two matches agree when they differ by at most this fraction of an image's span ...
constexpr double kToleranceRatio = 0.08;
// ... and this angle: maps are slightly deformed relative to each other.
constexpr double kToleranceRad = 0.05;
constexpr int kRememberedMatches = 30;  // of neighbours in both parts

/// A relative pose of parts a and b, and the pairs of keyframes that support it.
struct Hypothesis {
  Pose2 T_a_b;
  std::vector<graph::Edge> edges;
  std::unordered_set<std::int64_t> supporters;  // keyframes of b
};

/// Result of the test of a hypothesis.
struct Tested {
  Hypothesis hypothesis;
  int expected = 0;
  int matched = 0;
  int distinct = 0;                     // matches that are unique without a prior
  int with_depth = 0;                   // matches of a ceiling with depth
  std::vector<MatchQuality> qualities;  // of the matches
};

/// 0 .. n-1 so that every prefix is spread over the whole: first the ends' middle, then the
/// quarters, ...
std::vector<std::size_t> SpreadOrder(std::size_t n) {
  std::vector<std::size_t> order;
  std::vector<char> taken(n, 0);
  for (std::size_t step = std::max<std::size_t>(n / 2, 1);;
       step = std::max<std::size_t>(step / 2, 1)) {
    for (std::size_t i = step / 2; i < n; i += step) {
      if (taken[i] == 0) order.push_back(i);
      taken[i] = 1;
    }
    if (step == 1) break;
  }
  return order;
}

class Joiner {
 public:
  Joiner(LoopCloser& closer,
         std::span<const std::int64_t> a,
         std::span<const std::int64_t> b,
         const DescriptorSource& descriptors,
         JoinLight light)
      : closer_(closer),
        a_(a),
        b_(b),
        descriptors_(descriptors),
        same_light_(light == JoinLight::kSame) {}

  JoinResult Run();

 private:
  [[nodiscard]] Pose2 Pose(std::int64_t id) const { return closer_.Graph().T_map_base(id); }
  [[nodiscard]] bool SaysTheSame(const Hypothesis& hypothesis, const graph::Edge& edge) const;
  void Propose();
  void AddMatch(const graph::Edge& edge);
  [[nodiscard]] bool Decided() const;
  [[nodiscard]] bool Differ(const Hypothesis& x, const Hypothesis& y) const;
  [[nodiscard]] std::optional<std::int64_t> NearestInA(const Pose2& T_a_base) const;
  Tested Test(const Hypothesis& hypothesis);
  void LearnStandard(std::span<const std::int64_t> part);
  [[nodiscard]] bool IsAsGoodAsNeighbours(const Tested& tested) const;
  [[nodiscard]] bool AllAgreeWithDepth(const Tested& tested) const;
  void RemoveImitations(std::vector<Tested>& tested) const;
  [[nodiscard]] JoinResult Judge(const std::vector<Tested>& tested) const;

  LoopCloser& closer_;
  std::span<const std::int64_t> a_;
  std::span<const std::int64_t> b_;
  const DescriptorSource& descriptors_;
  bool same_light_;
  std::vector<Hypothesis> hypotheses_;
  MatchGate standard_{kRememberedMatches};
  int compared_ = 0;
  int ambiguous_ = 0;
};

/// Compares the pose of the match's keyframe of b with its pose under the hypothesis.
bool Joiner::SaysTheSame(const Hypothesis& hypothesis, const graph::Edge& edge) const {
  const Pose2 off =
      (hypothesis.T_a_b * Pose(edge.to)).Inverse() * (Pose(edge.from) * edge.T_from_to);
  return off.Translation().norm() < kToleranceRatio * closer_.Span() &&
         std::abs(off.yaw) < kToleranceRad;
}

void Joiner::AddMatch(const graph::Edge& edge) {
  for (Hypothesis& hypothesis : hypotheses_) {
    if (!SaysTheSame(hypothesis, edge)) continue;
    hypothesis.edges.push_back(edge);
    hypothesis.supporters.insert(edge.to);
    return;
  }
  hypotheses_.push_back(
      {Pose(edge.from) * edge.T_from_to * Pose(edge.to).Inverse(), {edge}, {edge.to}});
}

/// True when more matches would not change which hypothesis is the best.
bool Joiner::Decided() const {
  constexpr std::size_t kEnough = 8;
  constexpr std::size_t kTimes = 4;
  std::size_t best = 0;
  std::size_t second = 0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    const std::size_t n = hypothesis.supporters.size();
    second = std::max(second, std::min(n, best));
    best = std::max(best, n);
  }
  return best >= kEnough && best >= kTimes * second;
}

/// Whether two hypotheses differ by more than the deformation of the maps.
bool Joiner::Differ(const Hypothesis& x, const Hypothesis& y) const {
  constexpr double kTolerances = 1.2;
  return std::all_of(x.supporters.begin(), x.supporters.end(), [&](std::int64_t id) {
    const Pose2 off = (x.T_a_b * Pose(id)).Inverse() * (y.T_a_b * Pose(id));
    return off.Translation().norm() > kTolerances * kToleranceRatio * closer_.Span() ||
           std::abs(off.yaw) > kTolerances * kToleranceRad;
  });
}

void Joiner::Propose() {
  places::PlaceIndex index(places::PlaceDescriber::Dimension());
  for (const std::int64_t id : a_) index.Add(id, descriptors_(id));
  for (const std::size_t i : SpreadOrder(b_.size())) {
    if (compared_ >= kMaxComparisons || Decided()) break;
    for (const places::PlaceIndex::Match& match :
         index.Search(descriptors_(b_[i]), kCandidatesPerKeyframe)) {
      ++compared_;
      const Registration measured =
          closer_.Compare(match.keyframe_id, b_[i], closer_.CompassPrior(match.keyframe_id, b_[i]));
      ambiguous_ += measured.verdict == Verdict::kAmbiguous ? 1 : 0;
      if (!measured.ok()) continue;
      const graph::Edge edge = closer_.ClosureEdge(measured, match.keyframe_id, b_[i]);
      // A disturbed compass may leave parts unconnected, but never joins them in a wrong
      // orientation.
      if (!closer_.ContradictsCompass(edge)) AddMatch(edge);
    }
  }
  std::stable_sort(
      hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& x, const Hypothesis& y) {
        return x.supporters.size() > y.supporters.size();
      });
}

/// Learns the gate from consecutive keyframes, spread over the part.
void Joiner::LearnStandard(std::span<const std::int64_t> part) {
  const auto most = static_cast<std::size_t>(kRememberedMatches) / 2;
  std::size_t learned = 0;
  for (const std::size_t i : SpreadOrder(part.size())) {
    if (learned >= most) break;
    for (const std::size_t e : closer_.Graph().EdgesOf(part[i])) {
      const graph::Edge& edge = closer_.Graph().Edges()[e];
      if (edge.kind != graph::Edge::Kind::kOdometry || edge.to != part[i]) continue;
      const double known = kToleranceRatio * closer_.Span() / 3;
      const MotionPrior prior = closer_.Prior(edge.T_from_to, known, kToleranceRad / 3);
      const Registration measured = closer_.Compare(edge.from, edge.to, prior);
      ++compared_;
      if (!measured.ok()) continue;
      standard_.Add(
          QualityOf(measured, closer_.DissimilarityOf(edge.from, edge.to, measured.motion)));
      ++learned;
      break;
    }
  }
}

/// The keyframe of a whose image has the largest overlap with that of a robot at the given pose.
std::optional<std::int64_t> Joiner::NearestInA(const Pose2& T_a_base) const {
  // True overlaps of this size are almost always recognized (mapping/registration/README.md).
  constexpr double kMinOverlap = 0.6;
  std::optional<std::int64_t> nearest;
  double most = kMinOverlap;
  for (const std::int64_t id : a_) {
    if ((Pose(id).Translation() - T_a_base.Translation()).norm() > closer_.Span()) continue;
    const double overlap = closer_.Overlap(Pose(id).Inverse() * T_a_base);
    if (overlap <= most) continue;
    most = overlap;
    nearest = id;
  }
  return nearest;
}

Tested Joiner::Test(const Hypothesis& hypothesis) {
  Tested tested;
  tested.hypothesis = hypothesis;
  for (const std::size_t i : SpreadOrder(b_.size())) {
    if (tested.expected >= kMaxChecks) break;
    const Pose2 T_a_base = hypothesis.T_a_b * Pose(b_[i]);
    const std::optional<std::int64_t> from = NearestInA(T_a_base);
    if (!from) continue;
    ++tested.expected;
    ++compared_;
    const MotionPrior prior = closer_.Prior(
        Pose(*from).Inverse() * T_a_base, kToleranceRatio * closer_.Span() / 3, kToleranceRad / 3);
    const Registration measured = closer_.Compare(*from, b_[i], prior);
    if (!measured.ok()) continue;
    const graph::Edge edge = closer_.ClosureEdge(measured, *from, b_[i]);
    if (!SaysTheSame(hypothesis, edge)) continue;
    ++tested.matched;
    tested.qualities.push_back(
        QualityOf(measured, closer_.DissimilarityOf(*from, b_[i], measured.motion)));
    if (!measured.disambiguated_by_prior) ++tested.distinct;
    if (measured.heights) ++tested.with_depth;
    const bool known = std::any_of(
        tested.hypothesis.edges.begin(), tested.hypothesis.edges.end(), [&](const graph::Edge& e) {
          return e.from == edge.from && e.to == edge.to;
        });
    if (!known) tested.hypothesis.edges.push_back(edge);
  }
  return tested;
}

JoinResult Joiner::Judge(const std::vector<Tested>& tested) const {
  JoinResult result;
  result.compared = compared_;
  const auto holds = [&](const Tested& t) {
    return t.matched >= kMinMatches && t.matched >= kMinMatchRatio * t.expected;
  };
  const auto best =
      std::max_element(tested.begin(), tested.end(), [&](const Tested& x, const Tested& y) {
        if (holds(x) != holds(y)) return holds(y);
        const bool by_distinct = !same_light_ && holds(x) && x.distinct != y.distinct;
        return by_distinct ? x.distinct < y.distinct : x.matched < y.matched;
      });
  if (best == tested.end()) {
    result.verdict = ambiguous_ > 0 ? JoinResult::Verdict::kAmbiguous : result.verdict;
    result.reason =
        ambiguous_ > 0
            ? fmt::format(
                  "the ceiling is periodic: {} of {} pairs of images fit at several "
                  "positions, and none at only one",
                  ambiguous_,
                  compared_)
            : fmt::format("no overlap found: none of {} pairs of images agrees", compared_);
    return result;
  }
  result.expected = best->expected;
  result.matched = best->matched;
  if (best->matched < kMinMatches) {
    result.reason = fmt::format(
        "the overlap is too small: {} images agree, at least {} must; record a longer common "
        "stretch",
        best->matched,
        kMinMatches);
    return result;
  }
  if (!holds(*best)) {
    result.verdict = JoinResult::Verdict::kContradicts;
    result.reason =
        fmt::format("they contradict each other: where they overlap only {} of {} images agree",
                    best->matched,
                    best->expected);
    return result;
  }
  // Where nearly all images fit at only one position, a rival needs images that do so as well:
  // under a lattice of tiles and lamps, images fit at many positions where a prior expects them to.
  // Parts of one recording have the MatchGate instead.
  const bool unique = !same_light_ && best->distinct >= kMinUniqueRatio * best->matched;
  const auto rival = std::find_if(tested.begin(), tested.end(), [&](const Tested& t) {
    const bool as_many = unique ? t.distinct >= kRivalRatio * best->distinct
                                : t.matched >= kRivalRatio * best->matched;
    return holds(t) && as_many && Differ(t.hypothesis, best->hypothesis);
  });
  if (rival != tested.end() || best->distinct < kMinMatches) {
    result.verdict = JoinResult::Verdict::kAmbiguous;
    result.reason =
        fmt::format("the ceiling is periodic: several positions fit ({} and {} images agree)",
                    best->matched,
                    rival != tested.end() ? rival->matched : best->matched - best->distinct);
    return result;
  }
  // Rooms with the same lattice of tiles and lamps agree at one position as well as one room does,
  // but hardly any of their images fit only there.
  if (!same_light_ && best->distinct < kMinDistinctRatio * best->matched) {
    result.verdict = JoinResult::Verdict::kAmbiguous;
    result.reason = fmt::format(
        "the ceiling is periodic: {} images agree, but only {} of them fit nowhere else",
        best->matched,
        best->distinct);
    return result;
  }
  if (!IsAsGoodAsNeighbours(*best) && !AllAgreeWithDepth(*best)) {
    result.verdict = JoinResult::Verdict::kAmbiguous;
    result.reason =
        fmt::format("the ceiling is periodic: {} images agree, but not as well as neighbours do",
                    best->matched);
    return result;
  }
  result.verdict = JoinResult::Verdict::kJoined;
  result.T_a_b = best->hypothesis.T_a_b;
  result.edges = best->hypothesis.edges;
  return result;
}

bool Joiner::IsAsGoodAsNeighbours(const Tested& tested) const {
  const MatchQuality quality = Median(tested.qualities);
  return same_light_ ? standard_.Accepts(quality)
                     : quality.peak >= kMinNeighbourPeakRatio * standard_.Typical().peak;
}

bool Joiner::AllAgreeWithDepth(const Tested& tested) const {
  return tested.distinct >= kMinDepthMatches &&
         tested.distinct >= kMinDepthRatio * tested.expected &&
         tested.with_depth >= kMinDepthRatio * tested.matched &&
         Median(tested.qualities).peak >= kMinDepthPeakRatio * standard_.Typical().peak;
}

/// Removes relative poses at which the images agree much worse than neighbours do, if there is a
/// better one: under a lattice of tiles and lamps they imitate the true pose.
void Joiner::RemoveImitations(std::vector<Tested>& tested) const {
  if (same_light_) return;
  const auto good = [this](const Tested& t) { return t.matched > 0 && IsAsGoodAsNeighbours(t); };
  if (std::none_of(tested.begin(), tested.end(), good)) return;
  std::erase_if(tested, [&](const Tested& t) { return !good(t); });
}

JoinResult Joiner::Run() {
  Propose();
  if (!hypotheses_.empty()) {
    LearnStandard(a_);
    LearnStandard(b_);
  }
  constexpr std::size_t kMaxTested = 4;
  std::vector<Tested> tested;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (tested.size() >= kMaxTested) break;
    tested.push_back(Test(hypothesis));
  }
  RemoveImitations(tested);
  return Judge(tested);
}

}  // namespace

JoinResult JoinParts(LoopCloser& closer,
                     std::span<const std::int64_t> a,
                     std::span<const std::int64_t> b,
                     const DescriptorSource& descriptors,
                     JoinLight light) {
  return Joiner(closer, a, b, descriptors, light).Run();
}

}  // namespace ceilmap::mapping
