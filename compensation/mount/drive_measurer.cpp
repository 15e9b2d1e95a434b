#include "compensation/mount/drive_measurer.hpp"

#include <algorithm>
#include <utility>

#include "calib/ceiling_view.hpp"
#include "compensation/mount/ceiling_registrar.hpp"
#include "compensation/mount/view_velocities.hpp"

namespace ceilmap::mount {
DriveMeasurer::DriveMeasurer(double ceiling_height_m, const std::vector<CeilingRecording>& parts)
    : ceiling_height_m_(ceiling_height_m), parts_(parts) {
  for (const CeilingRecording& part : parts) {
    KnownMotion motion;
    for (const CeilingKeyframe& keyframe : part.keyframes) {
      motion.cameras.push_back(keyframe.T_first_camera);
      motion.velocities.push_back(part.has_stamps ? keyframe.velocity
                                                  : calibration::ViewVelocity{});
      stamps_s_.push_back(keyframe.stamp_s);
    }
    motions_.push_back(std::move(motion));
  }
}

calibration::Drive DriveMeasurer::Measure(const calib::MountedCamera& up, bool accurate) const {
  constexpr int kTextured = 64;  // of about 300
  return Measure(up, accurate, kTextured);
}

calibration::Drive DriveMeasurer::MeasureAll(const calib::MountedCamera& up) const {
  constexpr int kAll = 1000;
  return Measure(up, true, kAll);
}

calibration::Drive DriveMeasurer::Measure(const calib::MountedCamera& up,
                                          bool accurate,
                                          int blocks) const {
  calibration::Drive drive;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const std::size_t start = drive.cameras.size();
    drive.starts.push_back(start);
    calibration::Recording measured =
        MeasurePairs(parts_[i], up, ceiling_height_m_, motions_[i], accurate, blocks);
    for (calibration::ViewPair& pair : measured.pairs) {
      pair.first += static_cast<int>(start);
      pair.second += static_cast<int>(start);
      drive.pairs.push_back(std::move(pair));
    }
    drive.cameras.insert(drive.cameras.end(), measured.cameras.begin(), measured.cameras.end());
    drive.velocities.insert(
        drive.velocities.end(), measured.velocities.begin(), measured.velocities.end());
  }
  return drive;
}

void DriveMeasurer::Improve(const std::vector<Pose2>& cameras) {
  auto next = cameras.begin();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    KnownMotion& motion = motions_[i];
    const auto end = next + static_cast<std::ptrdiff_t>(motion.cameras.size());
    motion.cameras.assign(next, end);
    next = end;
    if (!parts_[i].has_stamps) continue;
    std::vector<Pose2> rough;
    std::vector<calibration::ViewVelocity> velocities;
    for (const CeilingKeyframe& keyframe : parts_[i].keyframes) {
      rough.push_back(keyframe.T_first_camera);
      velocities.push_back(keyframe.velocity);
    }
    if (motion.heights.empty()) {
      motion.velocities = RefineVelocities(rough, velocities, motion.cameras);
      continue;
    }
    // Heights make the length of each step on the rough path inaccurate, but not its turn.
    std::vector<TimedPose> views;
    for (std::size_t k = 0; k < motion.cameras.size(); ++k) {
      views.push_back({parts_[i].keyframes[k].stamp_s, motion.cameras[k]});
    }
    motion.velocities = VelocitiesOf(views);
    for (std::size_t k = 0; k < velocities.size(); ++k) {
      motion.velocities[k].yaw_rad_s = velocities[k].yaw_rad_s;
    }
  }
}

void DriveMeasurer::UseHeights() {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    motions_[i].heights.clear();
    for (const CeilingKeyframe& keyframe : parts_[i].keyframes) {
      motions_[i].heights.push_back(keyframe.heights);
    }
  }
}

void DriveMeasurer::Improve(const std::vector<calibration::PointHeight>& heights,
                            const calib::MountedCamera& up) {
  const registration::Registrar registrar =
      CeilingRegistrar(calib::CeilingView(up, ceiling_height_m_));
  const heights::HeightField& grid = registrar.EmptyHeights();
  const auto on_grid = [&grid](const heights::HeightField& known) {
    if (known.grid == grid.grid) return known;
    return heights::Predict(known, grid, [](const Eigen::Vector2d& x, double) { return x; });
  };
  std::vector<heights::HeightField*> fields;
  for (KnownMotion& motion : motions_) {
    for (auto& known : motion.heights) {
      auto better = known ? std::make_shared<heights::HeightField>(on_grid(*known)) : nullptr;
      fields.push_back(better.get());
      known = std::move(better);
    }
  }
  for (const calibration::PointHeight& point : heights) {
    heights::HeightField* const field = fields[static_cast<std::size_t>(point.view)];
    if (field == nullptr) continue;
    heights::HeightCell& cell = field->cells[static_cast<std::size_t>(point.index)];
    cell.rho = static_cast<float>(point.rho);
    cell.sigma = std::min(cell.sigma, static_cast<float>(point.sigma));
  }
}

bool DriveMeasurer::HasDepth() const {
  return std::any_of(
      parts_.begin(), parts_.end(), [](const CeilingRecording& part) { return part.has_depth; });
}

std::vector<DriveStep> DriveMeasurer::Steps() const {
  std::vector<DriveStep> steps;
  std::size_t view = 0;
  for (const KnownMotion& motion : motions_) {
    const std::vector<Pose2>& part = motion.cameras;
    for (std::size_t i = 0; i < part.size(); ++i, ++view) {
      if (i == 0) continue;
      const Pose2 step = part[i - 1].Inverse() * part[i];
      steps.push_back({stamps_s_[view - 1],
                       stamps_s_[view],
                       Pose2{0, 0, -0.5 * step.yaw} * step.Translation(),
                       step.yaw});
    }
  }
  return steps;
}

}  // namespace ceilmap::mount
