#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/frame_reader.hpp"
#include "localization/compass/colour/line_features.hpp"

namespace ceilmap::colour {

/// Fit of lines to the bins of a cell.
using LineFit = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Compares scan lines with all bins of a cell at once, by one matrix product per cell.
///
/// kVictoria, kVictoria2013: the squared distance of the square roots of the frequencies
/// (Hellinger), each transition weighted by its rarity in the model (1 - frequency). The likelihood
/// is 1 / (noise + distance), so that a line that fits nowhere (occluded by a person) reduces it
/// only slightly more than a line that fits badly. kSturm: the logarithm of a Gaussian with the
/// mean and variance of each frequency.
class LineMatcher {
 public:
  /// @param noise  Noise of the distance, see ColourCompassParams::line_noise.
  /// @param changed_fraction  See ColourCompassParams.
  LineMatcher(const ColourModel& model, double noise, double changed_fraction);

  /// To be called after the whole model has changed.
  void Update(const ColourModel& model);
  /// To be called after the model has learned in one cell. The weights of transitions are updated
  /// only every 50 calls, because they change slowly and affect all cells.
  void Update(const ColourModel& model, int cell);
  /// Logarithm of the likelihood of each line in each direction, up to a constant.
  /// @param cell  A cell that is not empty.
  /// @param fit  One row per line, one column per bin; empty bins get the mean of the others.
  void Fit(const LineFeatures& features, int cell, LineFit& fit);
  /// Evidence of lines about directions in a room that changes: with the probability
  /// `changed_fraction` a line is independent of what was learned in its direction, and resembles
  /// any other line of the cell.
  ///
  ///     log(changed + (1 - changed) sum over readings of probability * likelihood / its mean)
  ///
  /// A line that fits everywhere (bare wall) therefore contributes little information, however well
  /// it fits, and a line that fits nowhere contributes none; only a line that is rare and fits
  /// contributes. kSturm: Fit of the first reading.
  void FitChanging(std::span<const Reading> readings, int cell, LineFit& fit);

 private:
  struct Prepared {
    Eigen::MatrixXf columns;    // kVictoria: weighted square roots; a column per bin
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
  int updates_ = 0;  // since the weights were computed
};

}  // namespace ceilmap::colour
