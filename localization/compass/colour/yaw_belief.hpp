#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "localization/compass/colour/place_grid.hpp"

namespace ceilmap::colour {

/// What is believed of yaw and place: a histogram, a row per place, a column per yaw. It turns with
/// the robot: a column stands for a yaw less the turns since the beginning, so turns cost no
/// interpolation and blur nothing.
class YawBelief {
 public:
  static constexpr int kYaws = 180;
  using Histogram = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Everything is as likely. @param places  at least one.
  explicit YawBelief(int places);

  /// The robot turned. @param sigma_rad  how well that is known, >= 0.
  void Turn(double turn_rad, double sigma_rad);
  /// It drove ahead, in the direction of each yaw. @param steps  as a part of the grid's spacing.
  void Drive(double steps, const std::vector<Place>& places);
  /// It may have gone to a neighbouring place. @param part  to each of them, [0, 0.2].
  void Walk(const std::vector<Place>& places, float part);
  /// Yaw of a column now, rad in [0, 2 pi).
  [[nodiscard]] double YawOf(int column) const;
  /// Weighs each place and yaw. @param log_likelihood  of the histogram's size.
  /// @return logarithm of the likelihood of all that was believed.
  double Weigh(const Histogram& log_likelihood);
  /// The place is known: weighs each yaw, and spreads it over places.
  /// @param likelihood  a value per yaw, >= 0. @param places  a weight per place.
  /// @return as Weigh.
  double WeighYaws(const Eigen::RowVectorXf& likelihood, const Eigen::VectorXf& places);

  struct Estimate {
    double yaw_rad = 0;        ///< in (-pi, pi]: mean about the most likely yaw
    double variance_rad2 = 0;  ///< about that
    double confidence = 0;     ///< part within 3 sigma of it
  };
  [[nodiscard]] Estimate Yaw() const;
  /// Of each column, over all places; and back, with all places as likely.
  [[nodiscard]] Eigen::RowVectorXf Yaws() const { return belief_.colwise().sum(); }
  [[nodiscard]] double Turned() const { return turned_rad_; }
  void Restore(const Eigen::RowVectorXf& yaws, double turned_rad);
  /// Of each place.
  [[nodiscard]] Eigen::VectorXf Places() const { return belief_.rowwise().sum(); }

 private:
  void Normalize();
  void PassOn(int column, int side, const std::vector<Place>& places);

  Histogram belief_;
  Histogram scratch_;
  double turned_rad_ = 0;
  /// Of each column: how far the places that are meant lie from those of the grid, in steps: where
  /// the robot drove since it was passed on to a neighbour.
  Eigen::Matrix2Xd ahead_ = Eigen::Matrix2Xd::Zero(2, kYaws);
};

}  // namespace ceilmap::colour
