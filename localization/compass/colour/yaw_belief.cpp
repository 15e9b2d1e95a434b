#include "localization/compass/colour/yaw_belief.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/pose2.hpp"

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

constexpr double kColumnRad = 2 * pi / YawBelief::kYaws;
/// Minimum probability, so that a robot that was carried away can be localized again.
constexpr float kMinProbability = 1e-6F;

}  // namespace

YawBelief::YawBelief(int places)
    : belief_(Histogram::Constant(places, kYaws, 1.F / static_cast<float>(places * kYaws))),
      scratch_(belief_) {}

double YawBelief::YawOf(int column) const {
  const double yaw = std::fmod(kColumnRad * column + turned_rad_, 2 * pi);
  return yaw < 0 ? yaw + 2 * pi : yaw;
}

void YawBelief::Turn(double turn_rad, double sigma_rad) {
  turned_rad_ = std::fmod(turned_rad_ + turn_rad, 2 * pi);
  // Passing a fraction to both neighbours adds exactly this variance.
  double variance = std::min(sigma_rad * sigma_rad, pi * pi) / (kColumnRad * kColumnRad);
  constexpr double kMaxFraction = 0.33;
  while (variance > 1e-9) {
    const double now = std::min(variance, 2 * kMaxFraction);
    const auto fraction = static_cast<float>(0.5 * now);
    scratch_ = (1 - 2 * fraction) * belief_;
    scratch_.leftCols(kYaws - 1) += fraction * belief_.rightCols(kYaws - 1);
    scratch_.rightCols(kYaws - 1) += fraction * belief_.leftCols(kYaws - 1);
    scratch_.col(0) += fraction * belief_.col(kYaws - 1);
    scratch_.col(kYaws - 1) += fraction * belief_.col(0);
    belief_.swap(scratch_);
    variance -= now;
  }
}

void YawBelief::Drive(double steps, const std::vector<Place>& places) {
  if (places.size() < 2) return;
  constexpr double kHalf = 0.5;
  for (int column = 0; column < kYaws; ++column) {
    const double yaw = YawOf(column);
    auto ahead = ahead_.col(column);
    ahead += steps * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    // The sides are numbered as in Place::neighbours.
    for (int axis = 0; axis < 2; ++axis) {
      while (std::abs(ahead(axis)) > kHalf) {
        const bool up = ahead(axis) > 0;
        PassOn(column, 2 * axis + (up ? 1 : 0), places);
        ahead(axis) -= up ? 1 : -1;
      }
    }
  }
}

// Probability that would leave the grid stays at its edge.
void YawBelief::PassOn(int column, int side, const std::vector<Place>& places) {
  scratch_.col(column).setZero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const int next = places[i].neighbours[static_cast<std::size_t>(side)];
    scratch_(next < 0 ? at : next, column) += belief_(at, column);
  }
  belief_.col(column) = scratch_.col(column);
}

void YawBelief::Walk(const std::vector<Place>& places, float fraction) {
  if (!(fraction > 0) || places.size() < 2) return;
  scratch_ = belief_;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (const int neighbour : places[i].neighbours) {
      if (neighbour < 0) continue;
      const auto at = static_cast<Eigen::Index>(i);
      scratch_.row(neighbour) += fraction * belief_.row(at);
      scratch_.row(at) -= fraction * belief_.row(at);
    }
  }
  belief_.swap(scratch_);
}

void YawBelief::Normalize() {
  const float sum = belief_.sum();
  const auto size = static_cast<float>(belief_.size());
  if (!(sum > 0) || !std::isfinite(sum)) {
    belief_.setConstant(1 / size);
    return;
  }
  belief_ = belief_.array() * ((1 - kMinProbability) / sum) + kMinProbability / size;
}

double YawBelief::Weigh(const Histogram& log_likelihood) {
  const float most = log_likelihood.maxCoeff();
  belief_.array() *= (log_likelihood.array() - most).exp();
  const double evidence = double{most} + std::log(std::max(double{belief_.sum()}, 1e-30));
  Normalize();
  return evidence;
}

double YawBelief::WeighYaws(const Eigen::RowVectorXf& likelihood, const Eigen::VectorXf& places) {
  const Eigen::RowVectorXf yaws = belief_.colwise().sum().cwiseProduct(likelihood);
  const double evidence = std::log(std::max(double{yaws.sum()}, 1e-30));
  belief_.noalias() = places * yaws;
  ahead_.setZero();
  Normalize();
  return evidence;
}

void YawBelief::Restore(const Eigen::RowVectorXf& yaws, double turned_rad) {
  belief_.rowwise() = yaws;
  scratch_ = belief_;
  ahead_.setZero();
  turned_rad_ = turned_rad;
  Normalize();
}

YawBelief::Estimate YawBelief::Yaw() const {
  const Eigen::RowVectorXf yaws = belief_.colwise().sum();
  Eigen::Index top = 0;
  yaws.maxCoeff(&top);
  const auto away = [top](int column) {
    return kColumnRad * std::remainder(static_cast<double>(column - top), kYaws);
  };
  double sum = 0;
  double mean = 0;
  for (int i = 0; i < kYaws; ++i) {
    sum += double{yaws(i)};
    mean += double{yaws(i)} * away(i);
  }
  mean /= sum;
  Estimate estimate;
  estimate.yaw_rad = WrapAngle(YawOf(static_cast<int>(top)) + mean);
  for (int i = 0; i < kYaws; ++i) {
    const double off = std::remainder(away(i) - mean, 2 * pi);
    estimate.variance_rad2 += double{yaws(i)} * off * off / sum;
  }
  // Variance of the width of a column.
  estimate.variance_rad2 += kColumnRad * kColumnRad / 12;
  constexpr double kSigmas = 3;
  constexpr double kBlunderRad = 0.5;  // an estimate with a larger error is wrong, whatever its
                                       // variance
  const double near = std::min(kSigmas * std::sqrt(estimate.variance_rad2), kBlunderRad);
  for (int i = 0; i < kYaws; ++i) {
    const double off = std::remainder(away(i) - mean, 2 * pi);
    if (std::abs(off) <= near) estimate.confidence += double{yaws(i)} / sum;
  }
  return estimate;
}

}  // namespace ceilmap::colour
