#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/frame_reader.hpp"
#include "localization/compass/colour/line_features.hpp"

namespace ceilmap::colour {

/// How well lines fit to the bins of a cell.
using LineFit = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Compares scan lines with all bins of a cell at once: one product of matrices a cell.
///
/// kVictoria: the squared distance of the roots of the frequencies (Hellinger), each transition
/// weighted by how rare it is in the model (1 - frequency); the likelihood is 1 / (noise +
/// distance), so that a line which fits nowhere (a person before it) costs little more than one
/// that fits badly.
/// kSturm: the logarithm of a Gaussian with the mean and variance of each frequency.
class LineMatcher {
 public:
  /// @param noise  of the distance, see ColourCompassParams::line_noise.
  /// @param changed_fraction  see there, too.
  LineMatcher(const ColourModel& model, double noise, double changed_fraction);

  /// After the model has learned anything.
  void Update(const ColourModel& model);
  /// After it has learned in one cell. Weights of transitions follow every 50 calls: they change
  /// slowly, and touch all cells.
  void Update(const ColourModel& model, int cell);
  /// Logarithm of how likely each line is in each direction, up to a constant.
  /// @param cell  one that is not empty. @param fit  a row per line, a column per bin; bins without
  ///   anything get the mean of the others.
  void Fit(const LineFeatures& features, int cell, LineFit& fit);
  /// What lines tell about directions where things come and go: with the probability
  /// `changed_fraction` a line has nothing to do with what was learned there, and looks like any
  /// other of the cell.
  ///
  ///     log(changed + (1 - changed) sum over readings of probability * likelihood / its mean)
  ///
  /// so a line that fits everywhere (bare wall) tells little, however well it fits, and one that
  /// fits nowhere tells nothing; only what is rare and fits counts. kSturm: Fit of the first one.
  void FitChanging(std::span<const Reading> readings, int cell, LineFit& fit);

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
  float changed_fraction_;
  Eigen::VectorXf weights_;  // of transitions
  std::vector<Prepared> cells_;
  LineFeatures scaled_;  // scratch
  LineFit one_;
  int updates_ = 0;  // since the weights were made
};

}  // namespace ceilmap::colour
