#pragma once

#include <Eigen/Core>
#include <vector>

#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/line_features.hpp"

namespace ceilmap::colour {

/// How well lines fit to the bins of a cell.
using LineFit = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Compares scan lines with all bins of a cell at once: one product of matrices a cell.
///
/// kVictoria: the squared distance of the roots of the frequencies (Hellinger), each transition
/// weighted by how rare it is in the model (1 - frequency); the fit is -log(noise + distance), so
/// that a line which fits nowhere (a person before it) costs little more than one that fits badly.
/// kSturm: the logarithm of a Gaussian with the mean and variance of each frequency.
class LineMatcher {
 public:
  /// @param noise  of the distance, see ColourCompassParams::line_noise.
  LineMatcher(const ColourModel& model, double noise);

  /// After the model has learned anything.
  void Update(const ColourModel& model);
  /// After it has learned in one cell. Weights of transitions follow every 50 calls: they change
  /// slowly, and touch all cells.
  void Update(const ColourModel& model, int cell);
  /// @param fit  a row per line, a column per bin; bins without anything get the mean of the
  /// others.
  /// @param cell  one that is not empty.
  void Fit(const LineFeatures& features, int cell, LineFit& fit);

 private:
  struct Prepared {
    Eigen::MatrixXf columns;    // kVictoria: weighted roots; a column per bin
    Eigen::MatrixXf inverse;    // kSturm: inverse variances
    Eigen::RowVectorXf offset;  // of each bin
    std::vector<char> empty;
  };

  void Weigh(const ColourModel& model);
  void PrepareVictoria(const std::vector<AngleBin>& bins, Prepared& prepared) const;
  static void PrepareSturm(const std::vector<AngleBin>& bins, Prepared& prepared);
  void Prepare(const ColourModel& model, std::size_t cell);

  ModelKind kind_;
  float noise_;
  Eigen::VectorXf weights_;  // of transitions
  std::vector<Prepared> cells_;
  LineFeatures scaled_;  // scratch
  int updates_ = 0;      // since the weights were made
};

}  // namespace ceilmap::colour
