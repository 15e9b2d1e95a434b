#include "calib/solve/rig_residual.hpp"

#include <Eigen/Geometry>

#include "calib/solve/levelling.hpp"
#include "calib/solve/pair_problem.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

struct SeenPlace {
  Vector2d place;
  Matrix2d by_tilt;
  Vector2d by_readout;
};

/// Where a view's ray meets the ceiling, from the camera at the time of the view. The row that
/// shows it is exposed while the camera has moved on.
SeenPlace OnCeilingAt(const Vector2d& ray,
                      double row,
                      const ViewVelocity& velocity,
                      double readout_s,
                      const Levelling& levelling) {
  const double time_s = row * readout_s;
  const double turn = time_s * velocity.yaw_rad_s;
  const LevelPoint point(levelling, ray, Eigen::Rotation2Dd(turn).toRotationMatrix());
  const Vector2d moving = Eigen::Rotation2Dd(0.5 * turn) * velocity.linear;
  return {time_s * moving + point.place,
          point.by_tilt,
          row * (moving + 0.5 * turn * QuarterTurn(moving) +
                 velocity.yaw_rad_s * QuarterTurn(point.place))};
}

class PlaceCost final : public ceres::SizedCostFunction<2, 2, 2, 1, 3, 3> {
 public:
  PlaceCost(const PlaceSights& sights, const Matrix2d& weight) : sights_(sights), weight_(weight) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const PlaceState state{
        parameters[0], parameters[1], *parameters[2], parameters[3], parameters[4]};
    PlaceDerivatives derivatives;
    Eigen::Map<Vector2d> residual(residuals);
    residual =
        weight_ * PlaceDifference(sights_, state, jacobians == nullptr ? nullptr : &derivatives);
    if (jacobians == nullptr) return true;
    WriteJacobian(weight_, derivatives.by_tilt, jacobians[0]);
    WriteJacobian(weight_, derivatives.by_centre, jacobians[1]);
    WriteJacobian(weight_, derivatives.by_readout, jacobians[2]);
    WriteJacobian(weight_, derivatives.by_first, jacobians[3]);
    WriteJacobian(weight_, derivatives.by_second, jacobians[4]);
    return true;
  }

 private:
  PlaceSights sights_;
  Matrix2d weight_;
};

}  // namespace

Vector2d PlaceDifference(const PlaceSights& sights,
                         const PlaceState& state,
                         PlaceDerivatives* derivatives) {
  const Levelling levelling(state.tilt[0], state.tilt[1]);
  const PointCorrespondence& place = *sights.place;
  const SeenPlace first =
      OnCeilingAt(place.first, place.first_row, sights.first_velocity, state.readout_s, levelling);
  const SeenPlace second = OnCeilingAt(
      place.second, place.second_row, sights.second_velocity, state.readout_s, levelling);
  const Eigen::Map<const Vector2d> centre(state.centre);
  const Matrix2d R_first_world = Eigen::Rotation2Dd(-state.first[2]).toRotationMatrix();
  const Matrix2d R_first_second =
      Eigen::Rotation2Dd(state.second[2] - state.first[2]).toRotationMatrix();
  const Vector2d moved =
      R_first_world * Vector2d(state.second[0] - state.first[0], state.second[1] - state.first[1]);
  const Vector2d turned = R_first_second * (centre + second.place);
  if (derivatives != nullptr) {
    derivatives->by_tilt = R_first_second * second.by_tilt - first.by_tilt;
    derivatives->by_centre = R_first_second - Matrix2d::Identity();
    derivatives->by_readout = R_first_second * second.by_readout - first.by_readout;
    derivatives->by_first << -R_first_world, -QuarterTurn(moved + turned);
    derivatives->by_second << R_first_world, QuarterTurn(turned);
  }
  return moved + turned - (centre + first.place);
}

ceres::CostFunction* NewPlaceCost(const PlaceSights& sights, const Matrix2d& weight) {
  return new PlaceCost(sights, weight);
}

}  // namespace ceilmap::calibration
