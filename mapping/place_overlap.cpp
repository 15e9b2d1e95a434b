#include "mapping/place_overlap.hpp"

#include <cmath>
#include <cstdint>
#include <set>
#include <unordered_map>
#include <vector>

#include "mapping/places/place_descriptor.hpp"
#include "mapping/places/place_index.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

namespace {

constexpr int kResembling = 6;       // candidates of an image of b
constexpr int kMinWindows = 6;       // of an image that agree on its motion to another
constexpr std::size_t kMinMeet = 3;  // images of b at one relative pose
constexpr double kMeetSpans = 0.1;   // tolerance of that pose: of an image's span, ...
constexpr double kMeetRad = 0.08;    // ... and of the rotation

/// A relative pose of the parts that an image of b proposes.
struct MeetingProposal {
  Pose2 T_a_b;
  std::int64_t id = 0;  // of the keyframe of b
  Pose2 T_b_view;       // of its image
};

bool ProposeTheSame(const MeetingProposal& x, const MeetingProposal& y, double span) {
  const Pose2 off = (x.T_a_b * y.T_b_view).Inverse() * (y.T_a_b * y.T_b_view);
  return off.Translation().norm() < kMeetSpans * span && std::abs(off.yaw) < kMeetRad;
}

}  // namespace

bool MayMeet(const calib::CeilingView& view,
             std::span<const graph::Keyframe> a,
             std::span<const graph::Keyframe> b,
             const DescriptorSource& descriptors) {
  places::PlaceIndex index(places::PlaceDescriber::Dimension());
  std::unordered_map<std::int64_t, Pose2> T_a_view;
  for (const graph::Keyframe& keyframe : a) {
    index.Add(keyframe.id, descriptors(keyframe.id));
    T_a_view[keyframe.id] = keyframe.pose.T_map_base * view.T_base_view();
  }
  const double unit =
      places::PlaceDescriptorParams::ForCamera(view.Size(), view.MetresPerPixel()).units_per_px;
  std::vector<MeetingProposal> proposals;
  for (const graph::Keyframe& keyframe : b) {
    const Pose2 T_b_view = keyframe.pose.T_map_base * view.T_base_view();
    for (const auto& match : index.Search(descriptors(keyframe.id), kResembling)) {
      if (match.windows < kMinWindows) continue;
      Pose2 T_stored_query = match.T_stored_query;
      T_stored_query.x *= unit;
      T_stored_query.y *= unit;
      const MeetingProposal proposal{
          T_a_view.at(match.keyframe_id) * T_stored_query * T_b_view.Inverse(),
          keyframe.id,
          T_b_view};
      std::set<std::int64_t> together = {keyframe.id};
      for (const MeetingProposal& other : proposals) {
        if (ProposeTheSame(proposal, other, SpanOf(view))) together.insert(other.id);
      }
      if (together.size() >= kMinMeet) return true;
      proposals.push_back(proposal);
    }
  }
  return false;
}

}  // namespace ceilmap::mapping
