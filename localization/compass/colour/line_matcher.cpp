#include "localization/compass/colour/line_matcher.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::colour {
namespace {

/// Minimum variance of a frequency, for kSturm: repeated observations of the same place differ by
/// at least this.
constexpr float kMinBinVariance = 4e-4F;

/// Empty bins give no information: they get the mean of the others.
void FillEmpty(const std::vector<char>& empty, LineFit& fit) {
  Eigen::VectorXf mean = Eigen::VectorXf::Zero(fit.rows());
  int known = 0;
  for (std::size_t b = 0; b < empty.size(); ++b) {
    if (empty[b] != 0) continue;
    mean += fit.col(static_cast<Eigen::Index>(b));
    ++known;
  }
  mean /= static_cast<float>(std::max(known, 1));
  for (std::size_t b = 0; b < empty.size(); ++b) {
    if (empty[b] != 0) fit.col(static_cast<Eigen::Index>(b)) = mean;
  }
}

}  // namespace

LineMatcher::LineMatcher(const ColourModel& model, double noise, double changed_fraction)
    : kind_(model.kind),
      noise_(static_cast<float>(noise)),
      changed_fraction_(static_cast<float>(changed_fraction)) {
  Update(model);
}

void LineMatcher::Update(const ColourModel& model) {
  cells_.resize(model.cells.size());
  Weigh(model);
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) Prepare(model, cell);
}

void LineMatcher::Update(const ColourModel& model, int cell) {
  constexpr int kKept = 50;
  if (++updates_ >= kKept) {
    Update(model);
  } else {
    Prepare(model, static_cast<std::size_t>(cell));
  }
}

void LineMatcher::Prepare(const ColourModel& model, std::size_t cell) {
  const std::vector<AngleBin>& bins = model.cells[cell].bins;
  Prepared& prepared = cells_[cell];
  prepared.columns.setZero(weights_.size(), static_cast<Eigen::Index>(bins.size()));
  prepared.offset.setZero(static_cast<Eigen::Index>(bins.size()));
  prepared.empty.clear();
  prepared.empty.reserve(bins.size());
  for (const AngleBin& bin : bins) prepared.empty.push_back(bin.empty() ? 1 : 0);
  if (kind_ != ModelKind::kSturm) {
    PrepareVictoria(bins, prepared);
  } else {
    PrepareSturm(bins, prepared);
  }
}

void LineMatcher::Weigh(const ColourModel& model) {
  updates_ = 0;
  weights_.setZero(static_cast<Eigen::Index>(model.classes.size() * model.classes.size()));
  int count = 0;
  for (const Cell& cell : model.cells) {
    for (const AngleBin& bin : cell.bins) {
      if (bin.empty()) continue;
      weights_ += bin.transitions;
      ++count;
    }
  }
  weights_ = 1 - (weights_ / static_cast<float>(std::max(count, 1))).array();
  weights_ = weights_.cwiseMax(0);
}

void LineMatcher::PrepareVictoria(const std::vector<AngleBin>& bins, Prepared& prepared) const {
  const Eigen::VectorXf roots = weights_.cwiseSqrt();
  for (std::size_t b = 0; b < bins.size(); ++b) {
    if (bins[b].empty()) continue;
    const auto at = static_cast<Eigen::Index>(b);
    prepared.columns.col(at) = roots.cwiseProduct(bins[b].transitions.cwiseMax(0).cwiseSqrt());
    prepared.offset(at) = prepared.columns.col(at).squaredNorm();
  }
}

void LineMatcher::PrepareSturm(const std::vector<AngleBin>& bins, Prepared& prepared) {
  prepared.inverse.setZero(prepared.columns.rows(), prepared.columns.cols());
  for (std::size_t b = 0; b < bins.size(); ++b) {
    if (bins[b].empty()) continue;
    const auto at = static_cast<Eigen::Index>(b);
    const Eigen::VectorXf variance = bins[b].variance.array() + kMinBinVariance;
    prepared.inverse.col(at) = variance.cwiseInverse();
    prepared.columns.col(at) = bins[b].transitions.cwiseProduct(prepared.inverse.col(at));
    // Terms of the exponent that do not depend on the line, and the normalisation factor.
    prepared.offset(at) = bins[b].transitions.dot(prepared.columns.col(at)) +
                          (variance / kMinBinVariance).array().log().sum();
  }
}

void LineMatcher::Fit(const LineFeatures& features, int cell, LineFit& fit) {
  const Prepared& prepared = cells_[static_cast<std::size_t>(cell)];
  if (kind_ != ModelKind::kSturm) {
    scaled_ = features.cwiseMax(0).cwiseSqrt() * weights_.cwiseSqrt().asDiagonal();
    fit.noalias() = -2 * scaled_ * prepared.columns;
    fit.colwise() += scaled_.rowwise().squaredNorm();
    fit.rowwise() += prepared.offset;
    fit = -(fit.array().cwiseMax(0) + noise_).log();
  } else {
    fit.noalias() = -2 * features * prepared.columns;
    scaled_ = features.cwiseAbs2();
    fit.noalias() += scaled_ * prepared.inverse;
    fit.rowwise() += prepared.offset;
    // The frequencies of one line are strongly dependent: the product of the published method is
    // overconfident.
    const float dependence = std::sqrt(static_cast<float>(features.cols()));
    fit *= -0.5F / dependence;
  }
  FillEmpty(prepared.empty, fit);
}

void LineMatcher::FitChanging(std::span<const Reading> readings, int cell, LineFit& fit) {
  if (kind_ == ModelKind::kSturm) {
    Fit(readings.front().features, cell, fit);
    return;
  }
  fit.setZero(readings.front().features.rows(),
              static_cast<Eigen::Index>(cells_[static_cast<std::size_t>(cell)].empty.size()));
  for (const Reading& reading : readings) {
    Fit(reading.features, cell, one_);
    one_ = one_.array().exp();
    one_.array().colwise() /= one_.rowwise().mean().array().eval();
    fit += static_cast<float>(reading.probability) * one_;
  }
  fit = (changed_fraction_ + (1 - changed_fraction_) * fit.array()).log();
}

}  // namespace ceilmap::colour
