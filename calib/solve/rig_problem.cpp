#include "calib/solve/rig_problem.hpp"

namespace ceilmap::calibration {
namespace {

template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;

template <typename T>
Vector2<T> Turned(const T& angle, const Vector2<T>& v) {
  using std::cos;
  using std::sin;
  return {cos(angle) * v.x() - sin(angle) * v.y(), sin(angle) * v.x() + cos(angle) * v.y()};
}

// Intersection of a ray of the tilted camera with the ceiling, from the camera, in units of Z.
template <typename T>
Vector2<T> OnCeiling(const T* tilt, const Eigen::Vector2d& ray) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  // Rodrigues' formula with an axis in the plane of x and y; smooth at no tilt.
  const T angle2 = tilt[0] * tilt[0] + tilt[1] * tilt[1];
  const bool small = angle2 < T(1e-12);
  const T angle = small ? T(0) : sqrt(angle2);
  const T a = small ? T(1) - angle2 / 6.0 : sin(angle) / angle;
  const T b = small ? T(0.5) - angle2 / 24.0 : (T(1) - cos(angle)) / angle2;
  const T x(ray.x());
  const T y(ray.y());
  const T along = tilt[0] * x + tilt[1] * y;
  const T c = T(1) - b * angle2;  // cos
  const T px = c * x + a * tilt[1] + b * along * tilt[0];
  const T py = c * y - a * tilt[0] + b * along * tilt[1];
  const T pz = c + a * (tilt[0] * y - tilt[1] * x);
  return {px / pz, py / pz};
}

// Where a view's ray meets the ceiling, from the camera at the time of the view. The row that shows
// it is exposed while the camera has moved on.
template <typename T>
Vector2<T> OnCeilingAt(const T* tilt,
                       const T& readout_s,
                       const Eigen::Vector2d& ray,
                       double row,
                       const ViewVelocity& velocity) {
  const T time_s = row * readout_s;
  const T turn = time_s * velocity.yaw_rad_s;
  const Vector2<T> moved = time_s * velocity.linear.cast<T>();
  return Turned<T>(0.5 * turn, moved) + Turned<T>(turn, OnCeiling(tilt, ray));
}

// Difference between the point of the first image and that of the second, transformed to the first.
struct PlaceDifference {
  const PointCorrespondence* place;
  ViewVelocity first_velocity;
  ViewVelocity second_velocity;

  template <typename T>
  Vector2<T> operator()(
      const T* tilt, const T* centre, const T* readout, const T* first, const T* second) const {
    const Vector2<T> c(centre[0], centre[1]);
    const Vector2<T> seen_first =
        c + OnCeilingAt(tilt, readout[0], place->first, place->first_row, first_velocity);
    const Vector2<T> seen_second =
        c + OnCeilingAt(tilt, readout[0], place->second, place->second_row, second_velocity);
    const Vector2<T> moved(second[0] - first[0], second[1] - first[1]);
    return Turned<T>(-first[2], moved) + Turned<T>(second[2] - first[2], seen_second) - seen_first;
  }
};

ViewVelocity VelocityOf(const Recording& recording, int view) {
  if (recording.velocities.empty()) return {};
  return recording.velocities[static_cast<std::size_t>(view)];
}

PlaceDifference DifferenceOf(const Recording& recording,
                             const ViewPair& pair,
                             const PointCorrespondence& place) {
  return {&place, VelocityOf(recording, pair.first), VelocityOf(recording, pair.second)};
}

struct PlaceResidual {
  PlaceDifference difference;
  double scale;  // focal length / standard deviation

  template <typename T>
  bool operator()(const T* tilt,
                  const T* centre,
                  const T* readout,
                  const T* first,
                  const T* second,
                  T* residual) const {
    Eigen::Map<Vector2<T>> out(residual);
    out = (scale * difference.place->whitening).cast<T>() *
          difference(tilt, centre, readout, first, second);
    return true;
  }
};

struct WanderResidual {
  double sigma;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    residual[0] = pose[0] / sigma;
    residual[1] = pose[1] / sigma;
    return true;
  }
};

// Base x in the axes of the levelled camera is (cos yaw, -sin yaw); the step across it, at the mean
// heading.
template <typename T>
T SideStep(const T& yaw, const T* from, const T* to) {
  const Vector2<T> moved(to[0] - from[0], to[1] - from[1]);
  return Turned<T>(yaw - 0.5 * (from[2] + to[2]), moved).y();
}

struct SlipResidual {
  double sigma;

  template <typename T>
  bool operator()(const T* yaw, const T* from, const T* to, T* residual) const {
    residual[0] = SideStep(yaw[0], from, to) / sigma;
    return true;
  }
};

Eigen::Vector2d CameraOf(const RigParameters::Pose& pose, const std::array<double, 2>& centre) {
  const Pose2 T_first_axle{pose[0], pose[1], pose[2]};
  return T_first_axle * Eigen::Vector2d(centre[0], centre[1]);
}

}  // namespace

Eigen::Vector2d PlaceError(const RigParameters& parameters,
                           const std::vector<RigParameters::Pose>& poses,
                           const Recording& recording,
                           const ViewPair& pair,
                           const PointCorrespondence& place,
                           double focal_px) {
  return focal_px * place.whitening *
         DifferenceOf(recording, pair, place)(parameters.tilt.data(),
                                              parameters.centre.data(),
                                              parameters.readout.data(),
                                              poses[static_cast<std::size_t>(pair.first)].data(),
                                              poses[static_cast<std::size_t>(pair.second)].data());
}

double SlipOf(const RigParameters& parameters, std::size_t view) {
  return SideStep(
      parameters.yaw[0], parameters.straight[view].data(), parameters.straight[view + 1].data());
}

Eigen::Vector2d TravelOf(const RigParameters& parameters) {
  if (parameters.straight.empty()) return Eigen::Vector2d::Zero();
  return CameraOf(parameters.straight.back(), parameters.centre) -
         CameraOf(parameters.straight.front(), parameters.centre);
}

RigProblem::RigProblem(const Recording& spin,
                       const Recording& straight,
                       const RigSolverParams& params,
                       const RigScales& scales,
                       RigParameters& parameters)
    : parameters_(parameters) {
  AddPlaces(spin, params.focal_px, scales.place_px, parameters.spin, 0);
  AddPlaces(straight,
            params.focal_px,
            scales.place_px,
            parameters.straight,
            static_cast<int>(parameters.spin.size()));
  AddSpin(scales.wander);
  AddStraight(scales.slip);
  Hold();
}

void RigProblem::AddPlaces(const Recording& recording,
                           double focal_px,
                           double sigma_px,
                           std::vector<RigParameters::Pose>& poses,
                           int first_view) {
  for (const ViewPair& pair : recording.pairs) {
    for (const PointCorrespondence& place : pair.places) {
      const auto id = problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PlaceResidual, 2, 2, 2, 1, 3, 3>(
              new PlaceResidual{DifferenceOf(recording, pair, place), focal_px / sigma_px}),
          new ceres::CauchyLoss(kCauchy),
          parameters_.tilt.data(),
          parameters_.centre.data(),
          parameters_.readout.data(),
          poses[static_cast<std::size_t>(pair.first)].data(),
          poses[static_cast<std::size_t>(pair.second)].data());
      owners.push_back({id, first_view + pair.first, first_view + pair.second, true});
    }
  }
}

void RigProblem::AddSpin(double wander) {
  for (std::size_t i = 0; i < parameters_.spin.size(); ++i) {
    const auto id = problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<WanderResidual, 2, 3>(new WanderResidual{wander}),
        nullptr,
        parameters_.spin[i].data());
    owners.push_back({id, static_cast<int>(i), -1, false});
  }
}

void RigProblem::AddStraight(double slip) {
  const int before = static_cast<int>(parameters_.spin.size());
  for (std::size_t i = 0; i + 1 < parameters_.straight.size(); ++i) {
    const auto id = problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<SlipResidual, 1, 1, 3, 3>(new SlipResidual{slip}),
        nullptr,
        parameters_.yaw.data(),
        parameters_.straight[i].data(),
        parameters_.straight[i + 1].data());
    const int view = before + static_cast<int>(i);
    owners.push_back({id, view, view + 1, false});
  }
}

void RigProblem::Hold() {
  // The first heading of the spin and the first pose of the straight drive define the frames.
  problem.SetManifold(parameters_.spin.front().data(), new ceres::SubsetManifold(3, {2}));
  blocks = {parameters_.tilt.data(), parameters_.centre.data()};
  if (!parameters_.straight.empty()) {
    problem.SetParameterBlockConstant(parameters_.straight.front().data());
    blocks.push_back(parameters_.yaw.data());
  }
  if (parameters_.readout_is_free) {
    blocks.push_back(parameters_.readout.data());
  } else {
    problem.SetParameterBlockConstant(parameters_.readout.data());
  }
  for (RigParameters::Pose& pose : parameters_.spin) blocks.push_back(pose.data());
  for (std::size_t i = 1; i < parameters_.straight.size(); ++i) {
    blocks.push_back(parameters_.straight[i].data());
  }
}

}  // namespace ceilmap::calibration
