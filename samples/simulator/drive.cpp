#include "samples/simulator/drive.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Vector2d;
constexpr double kMin = 1e-9;  // metres or radians; shorter pieces are omitted
// A corner that reverses the direction cannot be rounded.
constexpr double kLargestArc = 179 * kRadPerDeg;

std::vector<Vector2d> DistinctPoints(const std::vector<std::array<double, 2>>& points) {
  std::vector<Vector2d> distinct;
  for (const auto& point : points) {
    const Vector2d p(point[0], point[1]);
    if (distinct.empty() || (p - distinct.back()).norm() > 1e-3) distinct.push_back(p);
  }
  return distinct;
}

double Heading(const Vector2d& from, const Vector2d& to) {
  return std::atan2(to.y() - from.y(), to.x() - from.x());
}

}  // namespace

Drive::Drive(const std::vector<std::array<double, 2>>& points_m, const Path& path) {
  const std::vector<Vector2d> points = DistinctPoints(points_m);
  Pose2 start{points[0].x(), points[0].y(), 0};
  if (points.size() > 1) start.yaw = Heading(points[0], points[1]);
  pieces_.push_back({start, 0, 0, false, 0});
  double cut_m = 0;  // cut from the current line's start by the arc before it
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double length = (points[i + 1] - points[i]).norm();
    if (i + 2 == points.size()) {
      Add({{}, length - cut_m, 0, false, 0});
      break;
    }
    const double turn =
        WrapAngle(Heading(points[i + 1], points[i + 2]) - Heading(points[i], points[i + 1]));
    double radius = std::abs(turn) < kLargestArc ? path.corner_radius_m : 0;
    const double per_radius = std::tan(std::abs(turn) / 2);
    const double next_length = (points[i + 2] - points[i + 1]).norm();
    if (per_radius > kMin)
      radius = std::min(radius, std::min(length, next_length) / 2 / per_radius);
    const double next_cut = radius > 0 ? radius * per_radius : 0;
    Add({{}, length - cut_m - next_cut, 0, false, 0});
    AddCorner(turn, radius);
    cut_m = next_cut;
  }
  MakeStretches(path);
}

void Drive::Add(Piece piece) {
  if (piece.extent < kMin) return;
  piece.start = pieces_.back().At(pieces_.back().extent);
  piece.distance_m = pieces_.back().DistanceTo(pieces_.back().extent);
  pieces_.push_back(piece);
}

void Drive::AddCorner(double turn_rad, double radius_m) {
  const double sign = turn_rad < 0 ? -1 : 1;
  if (radius_m > kMin) {
    Add({{}, std::abs(turn_rad) * radius_m, sign / radius_m, false, 0});
  } else {
    Add({{}, std::abs(turn_rad), sign, true, 0});
  }
}

Pose2 Drive::Piece::At(double along) const {
  const double turn = curvature * along;
  const Pose2 end{start.x, start.y, WrapAngle(start.yaw + turn)};
  if (on_spot) return end;
  // The chord of the arc is rotated to the left by half of the turn.
  const double half = turn / 2;
  const double chord = std::abs(half) < 1e-9 ? along : along * std::sin(half) / half;
  return {start.x + chord * std::cos(start.yaw + half),
          start.y + chord * std::sin(start.yaw + half),
          end.yaw};
}

void Drive::MakeStretches(const Path& path) {
  double time_s = 0;
  for (std::size_t first = 0; first < pieces_.size();) {
    Stretch stretch{first, first, time_s, 0, path.speed_m_s, path.acceleration_m_s2};
    const bool on_spot = pieces_[first].on_spot;
    if (on_spot) {
      stretch.speed = path.turn_rate_deg_s * kRadPerDeg;
      stretch.acceleration = path.turn_acceleration_deg_s2 * kRadPerDeg;
    }
    do {
      stretch.extent += pieces_[stretch.last++].extent;
    } while (!on_spot && stretch.last < pieces_.size() && !pieces_[stretch.last].on_spot);
    stretch.speed = std::min(stretch.speed, std::sqrt(stretch.extent * stretch.acceleration));
    if (stretch.extent > 0) {
      time_s += stretch.Duration();
      stretches_.push_back(stretch);
    }
    first = stretch.last;
  }
}

double Drive::Stretch::Duration() const {
  return extent / speed + speed / acceleration;
}

double Drive::Stretch::Along(double time_s) const {
  const double duration = Duration();
  const double t = std::clamp(time_s, 0.0, duration);
  const double rise_s = speed / acceleration;
  if (t < rise_s) return acceleration * t * t / 2;
  const double left_s = duration - t;
  if (left_s < rise_s) return extent - acceleration * left_s * left_s / 2;
  return speed * (t - rise_s / 2);
}

double Drive::Duration() const {
  return stretches_.empty() ? 0 : stretches_.back().start_s + stretches_.back().Duration();
}

Drive::Place Drive::PlaceAt(double time_s) const {
  auto stretch = std::upper_bound(
      stretches_.begin(), stretches_.end(), time_s, [](double t, const Stretch& s) {
        return t < s.start_s;
      });
  if (stretch != stretches_.begin()) --stretch;
  double along = stretch->Along(time_s - stretch->start_s);
  std::size_t piece = stretch->first;
  while (piece + 1 < stretch->last && along > pieces_[piece].extent) {
    along -= pieces_[piece++].extent;
  }
  return {piece, along};
}

Pose2 Drive::PoseAt(double time_s) const {
  if (stretches_.empty()) return pieces_.front().start;
  const Place place = PlaceAt(time_s);
  return pieces_[place.piece].At(place.along);
}

double Drive::DistanceAt(double time_s) const {
  if (stretches_.empty()) return 0;
  const Place place = PlaceAt(time_s);
  return pieces_[place.piece].DistanceTo(place.along);
}

}  // namespace ceilmap::simulator
