#include "tests/integration/recording_bag.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/files/odometry_csv.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/frame_source.hpp"
#include "calib/rig.hpp"
#include "tests/support/test_bag.hpp"

namespace ceilmap::integration {
namespace {

namespace fs = std::filesystem;
using recordings::Frame;
using recordings::FrameSource;
using recordings::Pixels;

constexpr std::int64_t kLateNs = 20'000'000;

bags::Transform ToTransform(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  return {{t.x(), t.y(), t.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

/// A camera's recording and what describes it.
struct Camera {
  std::string name;
  std::unique_ptr<FrameSource> source;
  calib::MountedCamera mounted;
};

class RecordingBag {
 public:
  RecordingBag(const fs::path& folder, const fs::path& bag, const RecordingBagOptions& options)
      : start_s_(options.start_s), bag_(bag, options.file) {
    const calib::Rig rig = calib::ReadRig(folder / "rig.yaml");
    AddCamera(folder, "up", Pixels::kGrey, rig.up);
    AddCamera(folder, "forward", Pixels::kGrey, rig.forward);
    AddCamera(folder, "omni", Pixels::kColour, rig.omni);
    if (fs::exists(folder / "odometry.csv")) {
      odometry_ = files::ReadOdometry(folder / "odometry.csv").poses;
    } else {
      for (const StampedPose& pose : files::ReadTum(folder / "truth.tum")) {
        odometry_.push_back({pose.stamp_s, PlanarPose(pose)});
      }
    }
    if (fs::exists(folder / "gyro.csv")) gyro_ = files::ReadGyro(folder / "gyro.csv").samples;
  }

  void Write() {
    bool more = true;
    for (bool first = true; more; first = false) {
      more = false;
      for (Camera& camera : cameras_) {
        Frame frame;
        if (!camera.source->Read(frame)) continue;
        if (first) WriteFrames(frame.stamp_s);
        WriteMotion(frame.stamp_s);
        WriteImage(camera, frame);
        more = true;
      }
    }
    constexpr double kAll = 1e12;
    WriteMotion(kAll);
    bag_.Commit();
  }

 private:
  void AddCamera(const fs::path& folder,
                 const std::string& name,
                 Pixels pixels,
                 const std::optional<calib::MountedCamera>& mounted) {
    const fs::path video = folder / (name + ".mp4");
    if (!mounted || !fs::exists(video)) return;
    cameras_.push_back(
        {name,
         std::make_unique<FrameSource>(
             video.string(),
             recordings::FrameSourceOptions{.pixels = pixels, .stamps = folder / "frames.csv"}),
         *mounted});
  }

  [[nodiscard]] std::int64_t Stamp(double stamp_s) const {
    return bags::Nanoseconds(start_s_ + stamp_s);
  }

  void WriteFrames(double stamp_s) {
    if (std::exchange(has_frames_, true)) return;
    std::vector<bags::TransformStamped> fixed;
    for (const Camera& camera : cameras_) {
      fixed.push_back({{Stamp(stamp_s), "base_link"},
                       camera.name + "_optical_frame",
                       ToTransform(camera.mounted.T_base_cam)});
    }
    bag_.Write("/tf_static", bags::kTransformsType, Stamp(stamp_s), fixed);
  }

  void WriteMotion(double until_s) {
    for (; next_pose_ < odometry_.size() && odometry_[next_pose_].stamp_s <= until_s;
         ++next_pose_) {
      const auto& [stamp_s, T_odom_base] = odometry_[next_pose_];
      const StampedPose pose = ToStampedPose(stamp_s, T_odom_base);
      bags::OdometryMessage message;
      message.header = {Stamp(stamp_s), "odom"};
      message.child_frame_id = "base_link";
      const Eigen::Quaterniond& q = pose.orientation;
      message.pose = {{pose.position.x(), pose.position.y(), 0}, {q.x(), q.y(), q.z(), q.w()}};
      const std::int64_t log_ns = message.header.stamp_ns + kLateNs;
      bag_.Write("/odom", bags::kOdometryType, log_ns, message);
      bag_.Write("/tf",
                 bags::kTransformsType,
                 log_ns,
                 std::vector{
                     bags::TransformStamped{message.header, message.child_frame_id, message.pose}});
    }
    for (; next_rate_ < gyro_.size() && gyro_[next_rate_].stamp_s <= until_s; ++next_rate_) {
      const auto& [stamp_s, yaw_rate_rad_s] = gyro_[next_rate_];
      bag_.Write("/imu",
                 bags::kImuType,
                 Stamp(stamp_s) + kLateNs,
                 bags::ImuMessage{{Stamp(stamp_s), "base_link"}, {0, 0, yaw_rate_rad_s}});
    }
  }

  void WriteImage(const Camera& camera, const Frame& frame) {
    const bags::Header header{Stamp(frame.stamp_s), camera.name + "_optical_frame"};
    bags::ImageMessage message;
    message.header = header;
    message.width = static_cast<std::uint32_t>(frame.image.cols);
    message.height = static_cast<std::uint32_t>(frame.image.rows);
    message.encoding = frame.image.channels() == 1 ? "mono8" : "bgr8";
    message.step = message.width * static_cast<std::uint32_t>(frame.image.channels());
    message.data = {frame.image.data, frame.image.total() * frame.image.elemSize()};
    const std::string topic = "/" + camera.name;
    bag_.Write(topic + "/image_raw", bags::kImageType, header.stamp_ns + kLateNs, message);
    const calib::Lens& lens = camera.mounted.camera;
    bags::CameraInfoMessage info{header,
                                 message.height,
                                 message.width,
                                 std::string(calib::RosName(lens.model)),
                                 lens.Coefficients(),
                                 {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1}};
    bag_.Write(topic + "/camera_info", bags::kCameraInfoType, header.stamp_ns + kLateNs, info);
  }

  double start_s_;
  support::TestBag bag_;
  std::vector<Camera> cameras_;
  std::vector<wheels::OdometrySample> odometry_;
  std::vector<wheels::GyroSample> gyro_;
  std::size_t next_pose_ = 0;
  std::size_t next_rate_ = 0;
  bool has_frames_ = false;
};

}  // namespace

void WriteRecordingBag(const fs::path& folder,
                       const fs::path& bag,
                       const RecordingBagOptions& options) {
  RecordingBag(folder, bag, options).Write();
}

}  // namespace ceilmap::integration
