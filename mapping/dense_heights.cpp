#include "mapping/dense_heights.hpp"

#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

#include "calib/base/parallel.hpp"
#include "mapping/heights/stereo.hpp"
#include "mapping/mosaic/image_cache.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

constexpr std::size_t kMaxPartners = 3;
// Travel of the reference plane between two keyframes, as a part of the image's longer side.
constexpr double kMinTravel = 0.05;
constexpr double kBestTravel = 0.14;
constexpr double kMaxTravel = 0.28;
constexpr int kKeptImages = 32;

struct Partner {
  std::size_t keyframe = 0;
  double rotation_rad = 0;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // as heights::StereoPartner
  double off_best = 0;                                 // difference to the best travel
};

/// Partners in several directions: each hides something else, and an edge along one travel is
/// measured by another.
std::vector<Partner> ChoosePartners(const calib::CeilingView& view,
                                    const std::vector<graph::Keyframe>& keyframes,
                                    std::size_t reference) {
  const double longer = std::max(view.Size().width, view.Size().height);
  const Eigen::Vector2d principal = registration::PlaneCameraOf(view).principal_px;
  const Pose2 T_ref_map = keyframes[reference].pose.T_map_base.Inverse();
  std::vector<Partner> near;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    if (i == reference) continue;
    const Pose2 T_ref_cur = T_ref_map * keyframes[i].pose.T_map_base;
    if (T_ref_cur.Translation().norm() > SpanOf(view)) continue;
    const registration::ImageMotion motion = ImageMotionOf(view, T_ref_cur);
    Partner partner{i, motion.theta_rad, motion.Apply(principal) - principal, 0};
    const double travel = partner.shift_px.norm() / longer;
    if (travel < kMinTravel || travel > kMaxTravel) continue;
    partner.off_best = std::abs(std::log(travel / kBestTravel));
    near.push_back(partner);
  }
  std::sort(near.begin(), near.end(), [](const Partner& a, const Partner& b) {
    return a.off_best < b.off_best;
  });
  const auto direction = [](const Partner& partner) {
    return Eigen::Vector2d(Eigen::Rotation2Dd(-partner.rotation_rad) *
                           partner.shift_px.normalized());
  };
  std::vector<Partner> chosen;
  for (const double max_cosine : {0.8, 1.0}) {
    for (const Partner& partner : near) {
      if (chosen.size() == kMaxPartners) return chosen;
      const bool similar = std::any_of(chosen.begin(), chosen.end(), [&](const Partner& other) {
        return other.keyframe == partner.keyframe ||
               direction(other).dot(direction(partner)) > max_cosine;
      });
      if (!similar) chosen.push_back(partner);
    }
  }
  return chosen;
}

}  // namespace

void MeasureDenseHeights(const calib::CeilingView& view,
                         const std::function<cv::Mat(std::int64_t)>& load,
                         int threads,
                         graph::MapGraph& graph) {
  std::vector<std::size_t> references;
  for (std::size_t i = 0; i < graph.keyframes.size(); ++i) {
    const auto& heights = graph.keyframes[i].heights;
    if (heights && heights->step_px.x() > heights::kStereoStepPx) references.push_back(i);
  }
  // Reduced and normalized once for all pairs.
  mosaic::ImageCache images([&load](std::int64_t id) { return heights::ForStereo(load(id)); },
                            kKeptImages);
  if (threads == 0) threads = static_cast<int>(std::thread::hardware_concurrency());
  ParallelFor(static_cast<int>(references.size()), std::max(threads, 1), [&](int at) {
    const std::size_t i = references[static_cast<std::size_t>(at)];
    graph::Keyframe& keyframe = graph.keyframes[i];
    std::vector<heights::StereoPartner> partners;
    for (const Partner& partner : ChoosePartners(view, graph.keyframes, i)) {
      partners.push_back({*images.Get(graph.keyframes[partner.keyframe].id),
                          partner.rotation_rad,
                          partner.shift_px});
    }
    if (partners.empty()) return;
    const heights::StereoReference reference{*images.Get(keyframe.id),
                                             view.Size(),
                                             view.Mask(),
                                             registration::PlaneCameraOf(view).principal_px};
    keyframe.heights = std::make_shared<const heights::HeightField>(
        heights::MeasureByStereo(reference, partners, *keyframe.heights));
  });
}

}  // namespace ceilmap::mapping
