#include "calib/solve/rig_problem.hpp"

#include "calib/solve/rig_residual.hpp"

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

ViewVelocity VelocityOf(const Recording& recording, int view) {
  if (recording.velocities.empty()) return {};
  return recording.velocities[static_cast<std::size_t>(view)];
}

PlaceSights SightsOf(const Recording& recording,
                     const ViewPair& pair,
                     const PointCorrespondence& place) {
  return {&place, VelocityOf(recording, pair.first), VelocityOf(recording, pair.second)};
}

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
  const PlaceState state{parameters.tilt.data(),
                         parameters.centre.data(),
                         parameters.readout[0],
                         poses[static_cast<std::size_t>(pair.first)].data(),
                         poses[static_cast<std::size_t>(pair.second)].data()};
  return focal_px * place.whitening *
         PlaceDifference(SightsOf(recording, pair, place), state, nullptr);
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
          NewPlaceCost(SightsOf(recording, pair, place), focal_px / sigma_px * place.whitening),
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
