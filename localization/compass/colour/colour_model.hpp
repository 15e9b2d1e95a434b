#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "localization/compass/colour/colour_classes.hpp"

namespace ceilmap::colour {

/// Maximum number of angle bins of all cells of a model together; each bin takes memory, observed
/// or not. 100 x 100 cells of 200 bins.
inline constexpr int kMaxBins = 2'000'000;
/// @throws InputError when there are more.
void CheckBinCount(int cells, int bins);

/// The paper that defines the model.
enum class ModelKind {
  /// A grid of positions; a bin has the mean of its observations, weighted by certainty and age.
  kVictoria,
  kSturm,  ///< one cylinder, mean and variance of each frequency (Sturm & Visser)
  /// The grid as in the paper (Methenitis et al. 2013, section 3.4): a bin has one observation,
  /// which a new one replaces if its certainty m(f) is greater.
  kVictoria2013,
};
const char* ToString(ModelKind kind);

/// Layout of the cells: columns along x, rows along y, in the frame of the learned poses.
struct GridGeometry {
  double min_x_m = 0;
  double min_y_m = 0;
  double width_m = 6;  ///< > 0
  double height_m = 4;
  int columns = 5;  ///< 1 .. 100
  int rows = 3;

  void Validate() const;  ///< throws InputError naming field, value and range
  [[nodiscard]] int Cells() const { return columns * rows; }
  /// Cell of a position; the nearest one for positions outside.
  [[nodiscard]] int CellOf(const Eigen::Vector2d& place) const;
};

/// Observations in one direction from one cell.
struct AngleBin {
  /// Frequencies of transitions, as LineFeatures; empty: no observation yet.
  Eigen::VectorXf transitions;
  /// kSturm: variance of each frequency, over the observed lines.
  Eigen::VectorXf variance;
  /// Certainty when it was stored: sum over observations of a weight that depends on how accurately
  /// position and heading were known, and on the distance of the line from the centre of the bin.
  double certainty = 0;
  double stamp_s = 0;     ///< of the last observation, from which the certainty decays
  Eigen::Vector2d place;  ///< mean position of the observations
  AngleBin() : place(Eigen::Vector2d::Zero()) {}

  [[nodiscard]] bool empty() const { return transitions.size() == 0; }
};

/// All directions from one cell: bin b is centred on the angle (b + 0.5) 2 pi / bins,
/// counter-clockwise from the x axis of the learned poses.
struct Cell {
  std::vector<AngleBin> bins;

  [[nodiscard]] bool empty() const;
  /// Fraction of the bins that have observations.
  [[nodiscard]] double Filled() const;
  /// Mean position over its bins; zero when empty.
  [[nodiscard]] Eigen::Vector2d Place() const;
};

/// A map of colours, from which robots without a ceiling camera estimate their heading. Stored in
/// one file (colour_model_file.hpp).
struct ColourModel {
  static constexpr int kVersion = 1;
  ModelKind kind = ModelKind::kVictoria;
  std::vector<ColourClass> classes;
  int bins = 180;  ///< per cell, 36 .. 720
  GridGeometry grid;
  std::vector<Cell> cells;  ///< grid.Cells() of them, row by row; one with kSturm
  /// Common distance of the observed objects, which determines the parallax when the robot is not
  /// at a learned position, m, > 0.
  double depth_m = 3.5;
  /// Time constant of the weight of observations: an observation loses weight by a factor of e in
  /// this time, s, > 0.
  double fading_s = 600;
  std::int64_t frames = 0;  ///< number of frames it was learned from
  std::string provenance;   ///< command lines, one per line

  /// @throws InputError where a condition stated above is violated.
  void Validate() const;
};

/// Bin that contains a direction, rad.
int BinOf(double angle_rad, int bins);

/// A possible position of the robot, in the frame of the learned poses.
struct PlaceHypothesis {
  Eigen::Vector2d place;
  double weight = 1;  ///< > 0; the weights need not sum to 1
};

/// Certainty of a bin at a later time: m(f) = e^(-(t - t_f) / fading_s) p(l_f) p(alpha_f) of
/// ViCTORiA. The paper prints e^(t - t_f), which grows with age, but states that "the reliability
/// of features over time will go down"; and it states no unit of time.
double FadedCertainty(const AngleBin& bin, double stamp_s, double fading_s);

/// Adds a model that another robot learned with the same classes, grid and bins: bin by bin,
/// weighted by certainty.
/// @throws InputError naming the difference.
void Merge(const ColourModel& other, ColourModel& model);

}  // namespace ceilmap::colour
