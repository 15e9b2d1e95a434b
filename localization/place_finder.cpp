#include "localization/place_finder.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <unordered_map>

namespace ceilmap::localization {

using places::PlaceDescriber;
using places::PlaceDescriptorParams;
using places::PlaceIndex;

namespace {

constexpr int kCandidates = 40;      // retrieval candidates evaluated per image, > 0
constexpr int kMaxPlaces = 6;        // maximum number of different places returned, > 0
constexpr int kMaxByDescriptor = 3;  // further ones found by a single local descriptor, >= 0
// Places that differ by less than this angle and PlaceFinder::kSameRatio are counted together.
constexpr double kSameRad = 0.15;
// Places with a smaller fraction of the best one's votes are dropped, [0, 1).
constexpr double kMinVotesRatio = 0.25;

PlaceDescriptorParams ParamsOf(const store::MapMetadata& metadata) {
  return PlaceDescriptorParams::ForCamera(metadata.view_size, metadata.view_units_per_px);
}

// Index of the map's keyframes by appearance.
struct Gallery {
  PlaceIndex index{PlaceDescriber::Dimension()};
  std::unordered_map<std::int64_t, Pose2> T_map_view;
};

std::shared_ptr<const Gallery> Fill(const store::MapReader& map, const std::atomic<bool>& stop) {
  auto gallery = std::make_shared<Gallery>();
  const Pose2& T_base_view = map.Metadata().T_base_view;
  for (const graph::Keyframe& keyframe : map.ReadKeyframes()) {
    if (stop) break;
    gallery->index.Add(keyframe.id, map.ReadDescriptors(keyframe.id));
    gallery->T_map_view[keyframe.id] = keyframe.pose.T_map_base * T_base_view;
  }
  return gallery;
}

}  // namespace

struct PlaceFinder::Impl {
  Impl(const store::MapReader& map, const calib::CeilingView& view)
      : descriptors(ParamsOf(map.Metadata())),
        describer(MakeDescriber(view)),
        // Descriptors on a server are read when they are needed: not by a robot with a known start.
        filling(
            std::async(map.IsRemote() ? std::launch::deferred : std::launch::async, [&map, this] {
              return Fill(map, stop);
            }).share()) {
    SetView(view);
  }
  ~Impl() { stop = true; }

  [[nodiscard]] PlaceDescriber MakeDescriber(const calib::CeilingView& view) const {
    return {view.Size(), view.MetresPerPixel(), descriptors, view.Mask()};
  }
  void SetView(const calib::CeilingView& view) {
    describer = MakeDescriber(view);
    T_view_base = view.T_base_view().Inverse();
    const int longer = std::max(view.Size().width, view.Size().height);
    same = kSameRatio * longer * view.MetresPerPixel();
  }

  PlaceDescriptorParams descriptors;
  Pose2 T_view_base;
  double same = 0;  // map units
  PlaceDescriber describer;
  std::shared_ptr<const Gallery> gallery;
  std::atomic<bool> stop{false};
  std::shared_future<std::shared_ptr<const Gallery>> filling;  // last: ends before what it uses

  [[nodiscard]] Pose2 PoseFrom(const PlaceIndex::Match& match) const;
  [[nodiscard]] std::vector<PlaceProposal> Gather(std::vector<PlaceProposal> single) const;
};

Pose2 PlaceFinder::Impl::PoseFrom(const PlaceIndex::Match& match) const {
  Pose2 T_stored_query = match.T_stored_query;
  T_stored_query.x *= descriptors.units_per_px;
  T_stored_query.y *= descriptors.units_per_px;
  return gallery->T_map_view.at(match.keyframe_id) * T_stored_query * T_view_base;
}

/// Starts with the strongest proposal and merges all that agree with it; repeats with the rest.
std::vector<PlaceProposal> PlaceFinder::Impl::Gather(std::vector<PlaceProposal> single) const {
  std::vector<PlaceProposal> places;
  while (!single.empty()) {
    const Pose2 first = single.front().T_map_base;
    PlaceProposal place;
    place.any_yaw = single.front().any_yaw;
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    std::erase_if(single, [&](const PlaceProposal& other) {
      const Eigen::Vector3d d(other.T_map_base.x - first.x,
                              other.T_map_base.y - first.y,
                              WrapAngle(other.T_map_base.yaw - first.yaw));
      const bool turned = !place.any_yaw && std::abs(d.z()) > kSameRad;
      if (d.head<2>().norm() > same || turned || other.any_yaw != place.any_yaw) return false;
      offset += other.votes * d;
      place.votes += other.votes;
      ++place.keyframes;
      return true;
    });
    offset /= place.votes;
    place.T_map_base = {
        first.x + offset.x(), first.y + offset.y(), WrapAngle(first.yaw + offset.z())};
    places.push_back(place);
  }
  std::stable_sort(
      places.begin(), places.end(), [](const PlaceProposal& a, const PlaceProposal& b) {
        return a.votes > b.votes;
      });
  // The best ones of each kind.
  std::array<int, 2> left = {kMaxPlaces, kMaxByDescriptor};
  std::array<double, 2> most = {0, 0};
  std::erase_if(places, [&](const PlaceProposal& place) {
    const std::size_t kind = place.any_yaw ? 1 : 0;
    most[kind] = std::max(most[kind], place.votes);
    return place.votes < kMinVotesRatio * most[kind] || left[kind]-- <= 0;
  });
  return places;
}

PlaceFinder::PlaceFinder(const store::MapReader& map, const calib::CeilingView& view) {
  impl_ = std::make_unique<Impl>(map, view);
}
PlaceFinder::~PlaceFinder() = default;

void PlaceFinder::SetView(const calib::CeilingView& view) {
  impl_->SetView(view);
}

std::vector<PlaceProposal> PlaceFinder::Find(
    const cv::Mat& image, const std::function<bool(const PlaceProposal&)>& wanted) {
  Impl& me = *impl_;
  if (!me.gallery) me.gallery = me.filling.get();  // throws each time when the map is damaged
  std::vector<PlaceProposal> single;
  for (const PlaceIndex::Match& match :
       me.gallery->index.Search(me.describer.Describe(image), kCandidates)) {
    const PlaceProposal proposal{me.PoseFrom(match), match.score, 1, match.windows == 0};
    if (!wanted || wanted(proposal)) single.push_back(proposal);
  }
  return me.Gather(std::move(single));
}

}  // namespace ceilmap::localization
