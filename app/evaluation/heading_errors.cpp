#include "app/evaluation/heading_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/evaluation/association.hpp"
#include "app/evaluation/robust_line.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::evaluation {
namespace {
constexpr double kMinPathM = 0.5;

// Adds full turns so that each angle is within half a turn of the previous one.
class Unwrapper {
 public:
  double operator()(double angle_rad) {
    if (!begun_) last_rad_ = angle_rad;
    begun_ = true;
    last_rad_ += WrapAngle(angle_rad - last_rad_);
    return last_rad_;
  }

 private:
  bool begun_ = false;
  double last_rad_ = 0;
};

double StandardDeviation(const std::vector<double>& values, double mean) {
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

std::vector<HeadingError> ErrorsOf(const std::vector<StampedHeading>& headings,
                                   const std::vector<StampedPose>& truth,
                                   double max_dt_s,
                                   HeadingZero zero) {
  std::vector<StampedPose> stamps;
  stamps.reserve(headings.size());
  for (const StampedHeading& heading : headings) stamps.push_back({.stamp_s = heading.stamp_s});
  const std::vector<double> distance_m = PathLengths(truth);
  std::vector<HeadingError> errors;
  Unwrapper true_yaw;
  Unwrapper error;
  double first_heading_rad = 0;
  double first_yaw_rad = 0;
  for (const auto& [k, i] : MatchStamps(truth, stamps, max_dt_s)) {
    const double heading_rad = headings[i].heading_rad;
    const double yaw_rad = true_yaw(YawOf(truth[k]));
    if (errors.empty() && zero == HeadingZero::kFirst) {
      first_heading_rad = heading_rad;
      first_yaw_rad = yaw_rad;
    }
    const double true_turn_rad = yaw_rad - first_yaw_rad;
    const double off_rad = WrapAngle(heading_rad - first_heading_rad - true_turn_rad);
    errors.push_back(
        {.heading = i,
         .truth = k,
         .true_deg = kDegPerRad * (first_heading_rad + true_turn_rad),
         .error_deg = kDegPerRad * (zero == HeadingZero::kFirst ? error(off_rad) : off_rad),
         .distance_m = distance_m[k]});
  }
  return errors;
}

}  // namespace

std::vector<StampedHeading> HeadingsOf(const std::vector<StampedPose>& poses) {
  std::vector<StampedHeading> headings;
  headings.reserve(poses.size());
  for (const StampedPose& pose : poses) headings.push_back({pose.stamp_s, YawOf(pose)});
  return headings;
}

std::optional<HeadingErrors> CompareHeadings(const std::vector<StampedHeading>& headings,
                                             const std::vector<StampedPose>& truth,
                                             double max_dt_s,
                                             HeadingZero zero) {
  HeadingErrors result;
  result.of = ErrorsOf(headings, truth, max_dt_s, zero);
  if (result.of.empty()) return std::nullopt;
  std::vector<double> errors_deg;
  std::vector<double> distances_m;
  std::vector<double> stamps_s;
  for (const HeadingError& error : result.of) {
    errors_deg.push_back(error.error_deg);
    distances_m.push_back(error.distance_m);
    stamps_s.push_back(headings[error.heading].stamp_s - headings[result.of[0].heading].stamp_s);
  }
  for (std::size_t i = 1; i < result.of.size(); ++i) {
    result.turned_deg += std::abs(result.of[i].true_deg - result.of[i - 1].true_deg);
  }
  const auto count = static_cast<double>(errors_deg.size());
  result.coverage = count / static_cast<double>(truth.size());
  result.path_m = distances_m.back() - distances_m.front();
  result.seconds = stamps_s.back();
  result.error_deg = Statistics(errors_deg);
  result.signed_mean_deg = std::accumulate(errors_deg.begin(), errors_deg.end(), 0.0) / count;
  result.std_deg = StandardDeviation(errors_deg, result.signed_mean_deg);
  result.end_deg = errors_deg.back();
  if (result.path_m > kMinPathM) result.drift_deg_per_m = RobustSlope(distances_m, errors_deg);
  result.drift_deg_per_s = RobustSlope(stamps_s, errors_deg);
  return result;
}

}  // namespace ceilmap::evaluation
