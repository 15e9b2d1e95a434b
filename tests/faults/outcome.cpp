#include "tests/faults/outcome.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "app/evaluation/alignment.hpp"
#include "app/files/status_csv.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

constexpr double kRightMetres = 0.05;
constexpr double kRightRad = 0.02;
constexpr double kSigmas = 4;

// Stamps go through text with six digits.
std::map<long long, const Shot*> ByStamp(const Recording& shots) {
  std::map<long long, const Shot*> by_stamp;
  for (const Shot& shot : shots) by_stamp[std::llround(1e5 * shot.stamp_s)] = &shot;
  return by_stamp;
}

const Shot* ShotAt(const std::map<long long, const Shot*>& by_stamp, double stamp_s) {
  const auto found = by_stamp.find(std::llround(1e5 * stamp_s));
  return found == by_stamp.end() ? nullptr : found->second;
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

std::vector<Estimate> PosesOfMap(const fs::path& map) {
  std::vector<Estimate> estimates;
  for (const graph::FramePose& pose : store::MapReader(map).ReadTrajectory()) {
    if (!graph::HasPose(pose.status)) continue;  // by the wheels alone
    estimates.push_back({pose.stamp_s, pose.T_map_base, pose.covariance});
  }
  return estimates;
}

std::vector<Estimate> PosesOfStatus(const fs::path& file) {
  const files::StatusRecord record = files::ReadStatus(file);
  std::vector<Estimate> estimates;
  for (std::size_t i = 0; i < record.poses.size(); ++i) {
    estimates.push_back(
        {record.poses[i].stamp_s, PlanarPose(record.poses[i]), record.covariances[i]});
  }
  return estimates;
}

Pose2 FitMap(const std::vector<Estimate>& estimates, const Recording& shots) {
  const auto by_stamp = ByStamp(shots);
  // A part of the map that is known to be uncertain must not move the others.
  constexpr double kMinSigmaM = 0.005;
  std::vector<PointPair> pairs;
  for (const Estimate& estimate : estimates) {
    const Shot* const shot = ShotAt(by_stamp, estimate.stamp_s);
    if (shot == nullptr) continue;
    const double variance_m2 =
        0.5 * estimate.covariance.topLeftCorner<2, 2>().trace() + kMinSigmaM * kMinSigmaM;
    pairs.push_back({shot->T_room_base.Translation(),
                     estimate.T_map_base.Translation(),
                     kMinSigmaM * kMinSigmaM / variance_m2});
  }
  if (pairs.empty()) return {};
  const std::optional<PlanarFit> fit = FitPlane(pairs, false);
  return fit ? fit->S_a_b.motion : evaluation::FitPlanarMotion(pairs);
}

// A pose at a stamp that no image has is as wrong as can be.
void Score(const std::vector<Estimate>& estimates,
           const Recording& shots,
           const Pose2& T_room_map,
           Outcome& outcome) {
  const auto by_stamp = ByStamp(shots);
  const Pose2 T_map_room = T_room_map.Inverse();
  double squares = 0;
  for (const Estimate& estimate : estimates) {
    ++outcome.placed;
    const Shot* const shot = ShotAt(by_stamp, estimate.stamp_s);
    if (shot == nullptr) {
      ++outcome.wrong;
      continue;
    }
    const Pose2 truth = T_map_room * shot->T_room_base;
    const Eigen::Vector2d off = estimate.T_map_base.Translation() - truth.Translation();
    const double turned = std::abs(WrapAngle(estimate.T_map_base.yaw - truth.yaw));
    squares += off.squaredNorm();
    outcome.largest_m = std::max(outcome.largest_m, off.norm());
    const Eigen::Matrix2d covariance = estimate.covariance.topLeftCorner<2, 2>();
    const bool far =
        off.norm() > kRightMetres && off.dot(covariance.inverse() * off) > kSigmas * kSigmas;
    const bool turned_far =
        turned > kRightRad && turned > kSigmas * std::sqrt(estimate.covariance(2, 2));
    outcome.wrong += far || turned_far ? 1 : 0;
  }
  if (outcome.placed > 0) outcome.rmse_m = std::sqrt(squares / outcome.placed);
}

double Outcome::Coverage() const {
  return shots > 0 ? static_cast<double>(placed) / shots : 0;
}

Outcome OutcomeOf(const support::ProcessResult& result, const Recording& shots) {
  Outcome outcome;
  outcome.exit_code = result.exit_code;
  outcome.shots = static_cast<int>(shots.size());
  constexpr int kUnusableInput = 2;
  outcome.orderly = result.exit_code >= 0 && result.exit_code <= kUnusableInput;
  if (result.exit_code == 0) return outcome;
  // Warnings may come before it; the error is the last line.
  const std::vector<std::string> lines = LinesOf(result.err);
  const std::string prefix = "ceilmap: ";
  if (!lines.empty() && lines.back().starts_with(prefix)) {
    outcome.message = lines.back().substr(prefix.size());
  }
  const auto is_error = [&](const std::string& line) {
    return !line.starts_with(prefix + "warning: ") && !line.starts_with(prefix + "note: ");
  };
  const bool one_line = std::count_if(lines.begin(), lines.end(), is_error) == 1;
  outcome.orderly = outcome.orderly && !outcome.message.empty() && one_line;
  return outcome;
}

}  // namespace ceilmap::faults
