#include "mapping/places/place_index.hpp"

// hnswlib's prefetching reads one word beyond its lists of links; without prefetching the search
// takes a fifth longer.
#define NO_MANUAL_VECTORIZATION
#include <fmt/format.h>
#include <hnswlib/hnswlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "mapping/places/place_fit.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::places {
namespace {

constexpr int kCandidates = 60;     // keyframes with most votes that are tested geometrically, > 0
constexpr double kTolerancePx = 5;  // of a window's place in that test, working pixels, > 0
constexpr int kLinks = 12;  // HNSW: links per stored window, [4, 64]; more: exacter and larger

constexpr int kPositionColumns = 2;  // columns of a window's position

// Squared distance of two vectors; a search in the graph computes about a thousand of these.
CEILMAP_HOT float SquaredDistance(const void* first, const void* second, const void* dimension) {
  const auto* a = static_cast<const float*>(first);
  const auto* b = static_cast<const float*>(second);
  const std::size_t n = *static_cast<const std::size_t*>(dimension);
  constexpr std::size_t kLanes = 16;
  std::array<float, kLanes> sums{};
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const float d = a[i + k] - b[i + k];
      sums[k] += d * d;
    }
  }
  float sum = 0;
  for (; i < n; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  for (const float s : sums) sum += s;
  return sum;
}

class VectorSpace : public hnswlib::SpaceInterface<float> {
 public:
  explicit VectorSpace(std::size_t dimension) : dimension_(dimension) {}
  std::size_t get_data_size() override { return dimension_ * sizeof(float); }
  hnswlib::DISTFUNC<float> get_dist_func() override { return SquaredDistance; }
  void* get_dist_func_param() override { return &dimension_; }

 private:
  std::size_t dimension_;
};

/// A stored window that is similar to one of the query.
struct Neighbour {
  float distance = 0;  // squared
  std::size_t window = 0;
  bool operator<(const Neighbour& other) const {
    return std::tie(distance, window) < std::tie(other.distance, other.window);
  }
};

/// Vote of one window of the query for a keyframe.
struct Vote {
  std::size_t keyframe = 0;
  int query = 0;           // row of the query
  float weight = 0;        // 0 .. 1
  std::size_t window = 0;  // stored
};

/// The votes [first, last) of a keyframe.
struct Candidate {
  std::size_t first = 0;
  std::size_t last = 0;
  float weight = 0;  // sum, with each window of the query counted once
};

// Votes by keyframe, then by window of the query, the strongest first.
std::vector<Candidate> GroupByKeyframe(std::vector<Vote>& votes) {
  std::sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) {
    return std::tie(a.keyframe, a.query, b.weight, a.window) <
           std::tie(b.keyframe, b.query, a.weight, b.window);
  });
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const bool same_keyframe = i > 0 && votes[i].keyframe == votes[i - 1].keyframe;
    if (!same_keyframe) candidates.push_back({i, i, 0});
    Candidate& candidate = candidates.back();
    candidate.last = i + 1;
    const bool counted = same_keyframe && votes[i].query == votes[i - 1].query;
    if (!counted) candidate.weight += votes[i].weight;
  }
  return candidates;
}

}  // namespace

void PlaceIndexParams::Validate() const {
  const FieldCheck require("PlaceIndexParams");
  require(neighbours >= 2 && neighbours <= 1024, "neighbours", neighbours, "in [2, 1024]");
  require(
      build_effort >= 16 && build_effort <= 1024, "build_effort", build_effort, "in [16, 1024]");
  require(search_effort >= 16 && search_effort <= 4096,
          "search_effort",
          search_effort,
          "in [16, 4096]");
}

struct PlaceIndex::Impl {
  Impl(int dimension_in, const PlaceIndexParams& params_in);

  void CheckRows(const cv::Mat& descriptors) const;
  void Reserve(std::size_t windows);
  void FindNeighbours(const float* vector,
                      const std::function<bool(std::int64_t)>& exclude,
                      std::vector<Neighbour>& neighbours) const;
  [[nodiscard]] std::vector<Vote> CollectVotes(
      const cv::Mat& descriptors, const std::function<bool(std::int64_t)>& exclude) const;
  [[nodiscard]] Match Test(const cv::Mat& descriptors,
                           std::span<const Vote> votes,
                           const Candidate& candidate,
                           std::vector<PlacePair>& pairs) const;

  static constexpr std::size_t kFirstCapacity = 1024;  // windows

  int dimension;
  PlaceIndexParams params;
  VectorSpace space;
  hnswlib::HierarchicalNSW<float> graph;
  std::size_t capacity = kFirstCapacity;
  std::vector<std::int64_t> keyframe_ids;
  std::set<std::int64_t> known;
  std::vector<std::size_t> keyframe_of;  // of each window, position in keyframe_ids
  std::vector<ImagePoint> places;        // of each window
};

PlaceIndex::Impl::Impl(int dimension_in, const PlaceIndexParams& params_in)
    : dimension(dimension_in),
      params(params_in),
      space(static_cast<std::size_t>(dimension_in - kPositionColumns)),
      graph(&space,
            kFirstCapacity,
            static_cast<std::size_t>(kLinks),
            static_cast<std::size_t>(params.build_effort)) {
  graph.setEf(static_cast<std::size_t>(params.search_effort));
}

void PlaceIndex::Impl::CheckRows(const cv::Mat& descriptors) const {
  if (descriptors.empty()) return;
  if (descriptors.type() != CV_32FC1 || descriptors.cols != dimension) {
    throw InputError(
        fmt::format("place index: descriptors must be CV_32FC1 with {} columns", dimension));
  }
  if (!cv::checkRange(descriptors)) {
    throw InputError("place index: descriptors must be finite");
  }
}

void PlaceIndex::Impl::Reserve(std::size_t windows) {
  if (windows <= capacity) return;
  const std::size_t larger = std::max(windows, 2 * capacity);
  graph.resizeIndex(larger);
  capacity = larger;
}

// The nearest windows of keyframes that are not excluded, nearest first. The graph does not support
// exclusion: the search is extended when too many are excluded.
void PlaceIndex::Impl::FindNeighbours(const float* vector,
                                      const std::function<bool(std::int64_t)>& exclude,
                                      std::vector<Neighbour>& neighbours) const {
  constexpr std::size_t kMaxAsked = 8;  // multiple of the requested number
  const auto wanted = static_cast<std::size_t>(params.neighbours);
  for (std::size_t asked = wanted;; asked *= 2) {
    neighbours.clear();
    auto found = graph.searchKnn(vector, std::min(asked, keyframe_of.size()));
    for (; !found.empty(); found.pop()) {
      const auto& [distance, window] = found.top();
      if (exclude && exclude(keyframe_ids[keyframe_of[window]])) continue;
      neighbours.push_back({distance, window});
    }
    const bool more = asked < keyframe_of.size() && asked < kMaxAsked * wanted;
    if (neighbours.size() >= wanted || !more) break;
  }
  std::sort(neighbours.begin(), neighbours.end());
  if (neighbours.size() > wanted) neighbours.resize(wanted);
}

std::vector<Vote> PlaceIndex::Impl::CollectVotes(
    const cv::Mat& descriptors, const std::function<bool(std::int64_t)>& exclude) const {
  // Squared distance of unrelated windows, used when there are too few windows to estimate it.
  constexpr float kDissimilarity = 0.7F;
  std::vector<Vote> votes;
  if (keyframe_of.empty()) return votes;
  std::vector<Neighbour> neighbours;
  for (int q = 0; q < descriptors.rows; ++q) {
    FindNeighbours(descriptors.ptr<float>(q) + kPositionColumns, exclude, neighbours);
    const bool enough = neighbours.size() == static_cast<std::size_t>(params.neighbours);
    const float dissimilarity = enough ? neighbours.back().distance : kDissimilarity;
    for (const Neighbour& neighbour : neighbours) {
      if (neighbour.distance >= dissimilarity) break;
      const float weight = 1 - neighbour.distance / dissimilarity;
      votes.push_back({keyframe_of[neighbour.window], q, weight, neighbour.window});
    }
  }
  return votes;
}

PlaceIndex::Match PlaceIndex::Impl::Test(const cv::Mat& descriptors,
                                         std::span<const Vote> votes,
                                         const Candidate& candidate,
                                         std::vector<PlacePair>& pairs) const {
  constexpr std::size_t kMaxPairs = 32;      // the cost is cubic
  constexpr double kVoteWithoutPlace = 0.1;  // relative to a vote with an agreeing position
  pairs.clear();
  for (const Vote& vote : votes.subspan(candidate.first, candidate.last - candidate.first)) {
    const auto* row = descriptors.ptr<float>(vote.query);
    pairs.push_back({ImagePoint(row[0], row[1]), places[vote.window], vote.weight});
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const PlacePair& a, const PlacePair& b) {
    return a.weight > b.weight;
  });
  if (pairs.size() > kMaxPairs) pairs.resize(kMaxPairs);
  const PlaceFit fit = BestFit(pairs, static_cast<float>(kTolerancePx));
  Match match;
  match.keyframe_id = keyframe_ids[votes[candidate.first].keyframe];
  match.score = fit.weight + kVoteWithoutPlace * candidate.weight;
  match.windows = fit.pairs;
  const ImagePoint at = fit.pairs > 0 ? fit.motion.shift : pairs.front().stored;
  match.T_stored_query = {at.real(), at.imag(), std::arg(fit.motion.turn)};
  return match;
}

PlaceIndex::PlaceIndex(int dimension, const PlaceIndexParams& params) {
  params.Validate();
  if (dimension <= kPositionColumns) {
    throw InputError(
        fmt::format("place index: dimension = {}, must be > {}", dimension, kPositionColumns));
  }
  impl_ = std::make_unique<Impl>(dimension, params);
}
PlaceIndex::~PlaceIndex() = default;
PlaceIndex::PlaceIndex(PlaceIndex&&) noexcept = default;
PlaceIndex& PlaceIndex::operator=(PlaceIndex&&) noexcept = default;

std::size_t PlaceIndex::KeyframeCount() const {
  return impl_->keyframe_ids.size();
}

void PlaceIndex::Add(std::int64_t keyframe_id, const cv::Mat& descriptors) {
  Impl& d = *impl_;
  d.CheckRows(descriptors);
  d.Reserve(d.keyframe_of.size() + static_cast<std::size_t>(descriptors.rows));
  if (!d.known.insert(keyframe_id).second) {
    throw InputError(fmt::format("place index: keyframe {} is known already", keyframe_id));
  }
  const std::size_t keyframe = d.keyframe_ids.size();
  d.keyframe_ids.push_back(keyframe_id);
  for (int i = 0; i < descriptors.rows; ++i) {
    const auto* row = descriptors.ptr<float>(i);
    d.graph.addPoint(row + kPositionColumns, d.keyframe_of.size());
    d.keyframe_of.push_back(keyframe);
    d.places.emplace_back(row[0], row[1]);
  }
}

std::vector<PlaceIndex::Match> PlaceIndex::Search(
    const cv::Mat& descriptors, int count, const std::function<bool(std::int64_t)>& exclude) const {
  const Impl& d = *impl_;
  d.CheckRows(descriptors);
  if (count < 1) {
    throw InputError(fmt::format("place index: count = {}, must be > 0", count));
  }
  const auto keep_first = [](auto& list, int most) {
    if (list.size() > static_cast<std::size_t>(most)) list.resize(static_cast<std::size_t>(most));
  };
  std::vector<Vote> votes = d.CollectVotes(descriptors, exclude);
  std::vector<Candidate> candidates = GroupByKeyframe(votes);
  std::stable_sort(candidates.begin(),
                   candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.weight > b.weight; });
  keep_first(candidates, std::max(count, kCandidates));
  std::vector<Match> matches;
  matches.reserve(candidates.size());
  std::vector<PlacePair> pairs;
  for (const Candidate& candidate : candidates) {
    matches.push_back(d.Test(descriptors, votes, candidate, pairs));
  }
  std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
    return a.score != b.score ? a.score > b.score : a.keyframe_id < b.keyframe_id;
  });
  keep_first(matches, count);
  return matches;
}

}  // namespace ceilmap::places
