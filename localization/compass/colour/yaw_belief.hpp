#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "localization/compass/colour/place_grid.hpp"

namespace ceilmap::colour {

/// Probability distribution of yaw and place: a histogram with a row per place and a column per
/// yaw. It rotates with the robot: a column stands for a yaw minus the turns since the beginning,
/// so that turns need no interpolation and do not blur the histogram.
class YawBelief {
 public:
  static constexpr int kYaws = 180;
  using Histogram = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Uniform distribution. @param places  At least one.
  explicit YawBelief(int places);

  /// Predicts a turn of the robot. @param sigma_rad  Standard deviation of the turn, >= 0.
  void Turn(double turn_rad, double sigma_rad);
  /// Predicts a forward motion, in the direction of each yaw. @param steps  Distance as a ratio of
  /// the grid's spacing.
  void Drive(double steps, const std::vector<Place>& places);
  /// Predicts a random motion to neighbouring places. @param fraction  Probability of each of them,
  /// [0, 0.2].
  void Walk(const std::vector<Place>& places, float fraction);
  /// Current yaw of a column, rad in [0, 2 pi).
  [[nodiscard]] double YawOf(int column) const;
  /// Weights each place and yaw. @param log_likelihood  Of the histogram's size.
  /// @return logarithm of the likelihood under the distribution before the call.
  double Weigh(const Histogram& log_likelihood);
  /// For a known place: weights each yaw, and distributes it over places.
  /// @param likelihood  One value per yaw, >= 0. @param places  One weight per place.
  /// @return as Weigh.
  double WeighYaws(const Eigen::RowVectorXf& likelihood, const Eigen::VectorXf& places);

  struct Estimate {
    double yaw_rad = 0;        ///< in (-pi, pi]: mean around the most likely yaw
    double variance_rad2 = 0;  ///< around that mean
    double confidence = 0;     ///< probability mass within 3 sigma of it
  };
  [[nodiscard]] Estimate Yaw() const;
  /// Probability of each column, over all places. Restore sets it again, with all places equally
  /// likely.
  [[nodiscard]] Eigen::RowVectorXf Yaws() const { return belief_.colwise().sum(); }
  [[nodiscard]] double Turned() const { return turned_rad_; }
  void Restore(const Eigen::RowVectorXf& yaws, double turned_rad);
  /// Probability of each place.
  [[nodiscard]] Eigen::VectorXf Places() const { return belief_.rowwise().sum(); }

 private:
  void Normalize();
  void PassOn(int column, int side, const std::vector<Place>& places);

  Histogram belief_;
  Histogram scratch_;
  double turned_rad_ = 0;
  /// For each column: offset between the places it represents and those of the grid, in steps. It
  /// is the distance driven since probability was last passed on to a neighbour.
  Eigen::Matrix2Xd ahead_ = Eigen::Matrix2Xd::Zero(2, kYaws);
};

}  // namespace ceilmap::colour
