#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/pose_with_covariance.hpp"
#include "calib/base/twist2.hpp"
#include "calib/wheels/dead_reckoning.hpp"

namespace ceilmap::wheels {

/// Why odometry cannot be that of this robot and recording.
enum class WheelFault {
  kNone,
  kOppositeYaw,     ///< the yaw has the opposite sign
  kOppositeTravel,  ///< the robot drives backwards by its wheels, or its base's x axis points back
  kUnits,           ///< the travel is many times too long or too short: not metres
  kTurnUnits,       ///< the turn is many times too large: degrees instead of radians
  kUnrelated,       ///< another robot's, another recording's, or another clock
};

/// Estimates the constants of wheels and gyro (WheelModel) while the ceiling shows the robot's
/// motion, and how large their noise is.
///
/// The motion is compared over short pieces of the way. An extended Kalman filter over scale, turn
/// scale, bias and the two delays takes the difference of each piece. A piece that contradicts the
/// estimate by more than four standard deviations is a slip and is left out. Where most pieces do,
/// the odometry is not used at all (Fault). Slips say how large those are that nothing sees
/// (SlipRate), where the ceiling is dark: their mean and scatter over the way, as if one more like
/// them had been missed.
///
/// Scale, turn scale and bias are observable on any drive with turns; the delays where speed or
/// turn rate change. What a drive does not show keeps the standard deviation it had.
class WheelCalibrator {
 public:
  /// @param first  What is known before.
  explicit WheelCalibrator(const WheelModel& first = {});

  /// The robot's pose at an image as the ceiling shows it, or that it is not known. Stamps
  /// increase.
  /// @param pose  in any frame that stays the same while there are poses. Its covariance: of the
  ///   measurement alone.
  /// @param velocity  of the robot at this time; nothing: that since the pose before, if it is less
  ///   than 0.3 s earlier. Without one nothing is learnt of the delays.
  /// @return true when the model has changed.
  bool Place(double stamp_s,
             const std::optional<PoseWithCovariance>& pose,
             const DeadReckoning& wheels,
             const std::optional<Twist2>& velocity = {});

  /// The same where only the heading is seen, by a compass: the turn scale or the bias of the gyro,
  /// and the delay of the turns, are estimated. Not to be mixed with Place.
  /// @param heading  from any direction that stays the same while there are headings. Its variance:
  ///   of the measurement alone.
  bool PlaceHeading(double stamp_s,
                    const std::optional<HeadingPrior>& heading,
                    const DeadReckoning& wheels,
                    const std::optional<Twist2>& velocity = {});

  [[nodiscard]] const WheelModel& Model() const { return model_; }
  [[nodiscard]] std::int64_t Pieces() const { return pieces_; }
  [[nodiscard]] std::int64_t Slips() const { return slips_; }  ///< pieces that were left out
  [[nodiscard]] WheelFault Fault() const;
  /// True travel / travel by the wheels, and the same of the turn, over all pieces; 0: not known.
  [[nodiscard]] double TravelRatio() const;
  [[nodiscard]] double TurnRatio() const;

 private:
  static constexpr int kConstants = 5;
  enum class Seen { kPose, kHeading };
  using Vector = Eigen::Matrix<double, kConstants, 1>;
  using Matrix = Eigen::Matrix<double, kConstants, kConstants>;
  using Jacobian = Eigen::Matrix<double, 3, kConstants>;
  struct Start {
    double stamp_s = 0;
    PoseWithCovariance pose;         // of the axle
    std::optional<Twist2> velocity;  // as seen, when it arrived
  };

  static Vector Values(const WheelModel& model);
  [[nodiscard]] WheelModel With(const Vector& values) const;
  static std::optional<Twist2> SeenVelocity(const Start& before, double stamp_s, const Pose2& pose);
  [[nodiscard]] Jacobian Derivatives(const Start& now, bool by_gyro) const;
  bool Arrive(double stamp_s,
              const std::optional<PoseWithCovariance>& pose,
              const DeadReckoning& wheels,
              const std::optional<Twist2>& velocity,
              Seen seen);
  [[nodiscard]] std::optional<RelativeMotion> Reported(double from_s,
                                                       double to_s,
                                                       const DeadReckoning& wheels,
                                                       Seen seen) const;
  bool Take(const Start& now,
            const Eigen::Matrix3d& measured,
            const DeadReckoning& wheels,
            Seen seen);
  void LearnTurnScale(double seen_rad, const RelativeTurn& by_wheels, double seen_rad2);
  void LearnNoise(const Eigen::VectorXd& difference, const Eigen::VectorXd& expected, bool by_gyro);
  void LearnYawNoise(double error, bool by_gyro);
  void LearnSlip(const Eigen::Vector2d& difference);
  void Count(const Pose2& seen, const Pose2& reported);

  WheelModel first_;
  WheelModel model_;
  Matrix covariance_;
  std::optional<Start> start_;   // of the piece
  std::optional<Start> latest_;  // the last pose
  std::int64_t pieces_ = 0;
  std::int64_t slips_ = 0;
  std::deque<double> travel_errors_;  // of the latest pieces, in standard deviations as stated ...
  std::deque<double> yaw_errors_;     // ... at first, of the wheels ...
  std::deque<double> gyro_errors_;    // ... and of the gyro
  // Slips: one may last several pieces.
  bool slipping_ = false;
  int slip_events_ = 0;
  Eigen::Vector2d slip_ = Eigen::Vector2d::Zero();      // the last one, m
  Eigen::Vector2d slip_sum_ = Eigen::Vector2d::Zero();  // of all
  double slip_squares_ = 0;                             // of those before the last one
  double travel_m_ = 0;                                 // over all pieces, as reported
  // Sums over the pieces, for Fault.
  double travel_both_ = 0;
  double travel_reported_ = 0;
  double turn_both_ = 0;
  double turn_reported_ = 0;
  double turn_seen_ = 0;
};

}  // namespace ceilmap::wheels
