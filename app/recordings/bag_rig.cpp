#include "app/recordings/bag_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "calib/base/yaml_text.hpp"
#include "calib/camera_info.hpp"

namespace ceilmap::recordings {
namespace {

constexpr double kFocalTolerance = 0.005;
constexpr double kPixelTolerance = 1;

bool IsCalibrated(const bags::CameraInfoMessage& info) {
  return info.k[0] > 0 && info.k[4] > 0;
}

/// Largest distance between the images of a ray at the corners by the distortion of two lenses.
double DistortionDifference(const calib::Lens& bag, calib::Lens rig) {
  rig.fx = bag.fx;
  rig.fy = bag.fy;
  rig.cx = bag.cx;
  rig.cy = bag.cy;
  double largest_px = 0;
  for (const double u : {0.0, bag.width_px - 1.0}) {
    for (const double v : {0.0, bag.height_px - 1.0}) {
      const auto ray = rig.Ray({u, v});
      const auto pixel = ray ? bag.Project(*ray) : std::nullopt;
      const double px = pixel ? (*pixel - Eigen::Vector2d(u, v)).norm() : bag.width_px;
      largest_px = std::max(largest_px, px);
    }
  }
  return largest_px;
}

std::string DistortionOf(const calib::Lens& lens) {
  return fmt::format(
      "{} [{:.6g}]", calib::RosName(lens.model), fmt::join(lens.Coefficients(), ", "));
}

std::vector<std::string> DifferencesOf(const calib::Lens& bag, const calib::Lens& rig) {
  if (bag.Size() != rig.Size()) {
    return {fmt::format("the size is {}x{} px, in the rig {}x{}",
                        bag.width_px,
                        bag.height_px,
                        rig.width_px,
                        rig.height_px)};
  }
  std::vector<std::string> differences;
  const auto compare = [&](const char* name, double value, double other) {
    if (std::abs(value - other) <= kFocalTolerance * rig.fx) return;
    differences.push_back(fmt::format("{} is {:.6g} px, in the rig {:.6g}", name, value, other));
  };
  compare("fx", bag.fx, rig.fx);
  compare("fy", bag.fy, rig.fy);
  compare("cx", bag.cx, rig.cx);
  compare("cy", bag.cy, rig.cy);
  if (DistortionDifference(bag, rig) > kPixelTolerance) {
    differences.push_back(
        fmt::format("the distortion is {}, in the rig {}", DistortionOf(bag), DistortionOf(rig)));
  }
  return differences;
}

std::string Indented(const std::string& text) {
  std::string result;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    result += "    " + text.substr(begin, end - begin);
    begin = end;
  }
  return result;
}

std::string CameraTextOf(const BagRobot& robot, const RigCamera& camera) {
  const BagCamera* const found = robot.CameraOf(camera.image_topic);
  if (found == nullptr) {
    throw InputError(fmt::format(
        "{}: has no camera_info of {}; give --rig RIG.yaml", robot.Name(), camera.image_topic));
  }
  if (!IsCalibrated(found->info)) {
    throw InputError(
        fmt::format("{}: the camera of {} was not calibrated (its K is zero); give --rig RIG.yaml",
                    robot.Name(),
                    found->topic));
  }
  const std::string frame = FrameName(found->info.header.frame_id);
  const std::optional<std::string> base = robot.Frames().BaseOf(frame);
  if (!base) {
    throw InputError(
        fmt::format("{}: /tf_static does not connect {}, the frame of {}, with base_link; give "
                    "--rig RIG.yaml",
                    robot.Name(),
                    frame.empty() ? "\"\"" : frame,
                    found->topic));
  }
  const Eigen::Isometry3d T_base_cam = *robot.Frames().Find(*base, frame);
  const Eigen::Quaterniond q(T_base_cam.linear());
  const Eigen::Vector3d t = T_base_cam.translation();
  return fmt::format(
      "  {}:\n    type: pinhole\n{}"
      "    base_link_to_camera: {{translation: [{}, {}, {}], rotation_xyzw: [{}, {}, {}, {}]}}\n",
      camera.name,
      Indented(CameraInfoText(found->info)),
      NumberText(t.x()),
      NumberText(t.y()),
      NumberText(t.z()),
      NumberText(q.x()),
      NumberText(q.y()),
      NumberText(q.z()),
      NumberText(q.w()));
}

// The name of the images' topic and what the bag says of its robot.
std::string ImageTopicOf(const std::string& bag, const BagTopic& topic) {
  const auto recording = topic.bags->Get(bag);
  return recording->Topics()[FindTopic(*recording, topic, TopicUse::kImages)].name;
}

}  // namespace

std::string CameraInfoText(const bags::CameraInfoMessage& info) {
  std::vector<double> d = info.d;
  const auto model = calib::FindLensModel(info.distortion_model);
  if (model) {
    const std::size_t count = calib::CoefficientNames(*model).size();
    const auto beyond = d.begin() + static_cast<std::ptrdiff_t>(std::min(count, d.size()));
    const bool superfluous = std::all_of(beyond, d.end(), [](double k) { return k == 0; });
    if (superfluous) d.resize(count);
  }
  std::string text = fmt::format(
      "image_width: {}\nimage_height: {}\n"
      "camera_matrix: {{rows: 3, cols: 3, data: [{}]}}\n"
      "distortion_model: {}\n",
      info.width,
      info.height,
      fmt::join(info.k, ", "),
      QuotedText(info.distortion_model));
  if (!d.empty()) {
    text += fmt::format("distortion_coefficients: {{rows: 1, cols: {}, data: [{}]}}\n",
                        d.size(),
                        fmt::join(d, ", "));
  }
  return text;
}

std::string CompareCamera(const BagRobot& robot,
                          const BagCamera& bag,
                          const std::string& camera,
                          const std::string& rig,
                          const calib::Lens& lens) {
  if (!IsCalibrated(bag.info)) return "";
  const std::string name = fmt::format("{}: {}", robot.Name(), bag.topic);
  try {
    const calib::Lens other = calib::ParseCameraInfo(CameraInfoText(bag.info), name);
    const std::vector<std::string> differences = DifferencesOf(other, lens);
    if (differences.empty()) return "";
    return fmt::format("{} is of another camera than '{}' of {}, which is used: {}",
                       name,
                       camera,
                       rig,
                       fmt::join(differences, "; "));
  } catch (const InputError& error) {
    return fmt::format("{}; '{}' of {} is used", error.what(), camera, rig);
  }
}

std::string RigTextOf(const BagRobot& robot,
                      const std::vector<RigCamera>& cameras,
                      double ceiling_height_m) {
  std::string text =
      fmt::format("# made from the camera_info and /tf_static of {}\nh: {}\ncameras:\n",
                  InOneLine(robot.Name()),
                  NumberText(ceiling_height_m));
  for (const RigCamera& camera : cameras) text += CameraTextOf(robot, camera);
  return text;
}

void PrintCameraDifference(const std::string& source,
                           const BagTopic& topic,
                           const std::string& name,
                           const calib::MountedCamera& camera,
                           const calib::Rig& rig) {
  if (!topic.bags || !IsBag(source) || !(camera.camera.fx > 0)) return;
  const BagRobot& robot = topic.bags->Robot(source);
  const BagCamera* const bag = robot.CameraOf(ImageTopicOf(source, topic));
  if (bag == nullptr) return;
  const std::string difference = CompareCamera(robot, *bag, name, rig.file.string(), camera.camera);
  if (!difference.empty()) terminal::PrintWarning(difference);
}

calib::Rig ReadBagRig(const std::string& up,
                      const BagTopic& up_topic,
                      const std::string& forward,
                      const BagTopic& forward_topic,
                      double ceiling_height_m) {
  if (!IsBag(up)) {
    throw InputError(fmt::format("--rig-from-bag: {} of --up is no bag; give --rig RIG.yaml", up));
  }
  const BagRobot& robot = up_topic.bags->Robot(up);
  std::vector<RigCamera> cameras{{"up", ImageTopicOf(up, up_topic)}};
  if (!forward.empty() && IsBag(forward) && up_topic.bags->Get(forward) == up_topic.bags->Get(up)) {
    cameras.push_back({"forward", ImageTopicOf(forward, forward_topic)});
  }
  return calib::ParseRig(RigTextOf(robot, cameras, ceiling_height_m), up + " (its rig)");
}

}  // namespace ceilmap::recordings
