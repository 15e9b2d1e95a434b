#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "localization/compass/colour/colour_classes.hpp"

namespace ceilmap::colour {

/// Angle bins of all cells of a model together: each takes memory, seen or not. 100 x 100 cells of
/// 200.
inline constexpr int kMaxBins = 2'000'000;
/// @throws InputError when there would be more.
void CheckBinCount(int cells, int bins);

/// Which paper's model.
enum class ModelKind {
  kVictoria,  ///< a grid of places, features with certainty
  kSturm,     ///< one cylinder, mean and variance of each frequency (Sturm & Visser)
};
const char* ToString(ModelKind kind);

/// Where cells lie: columns along x, rows along y, in the frame of the learned poses.
struct GridParams {
  double min_x_m = 0;
  double min_y_m = 0;
  double width_m = 6;  ///< > 0
  double height_m = 4;
  int columns = 5;  ///< 1 .. 100
  int rows = 3;

  void Validate() const;  ///< throws InputError naming field, value and range
  [[nodiscard]] int Cells() const { return columns * rows; }
  /// Cell of a place; the nearest one for places outside.
  [[nodiscard]] int CellOf(const Eigen::Vector2d& place) const;
};

/// What was seen in one direction from one cell.
struct AngleBin {
  /// Frequencies of transitions, as LineFeatures; empty: nothing was seen yet.
  Eigen::VectorXf transitions;
  /// kSturm: of each frequency, over the lines that were seen.
  Eigen::VectorXf variance;
  /// How sure it is when it was stored: sum over observations of how well place and heading were
  /// known, and how near to the middle of the bin the line was.
  double certainty = 0;
  double stamp_s = 0;     ///< of the last observation: certainty fades from there
  Eigen::Vector2d place;  ///< mean place of the observations
  AngleBin() : place(Eigen::Vector2d::Zero()) {}

  [[nodiscard]] bool empty() const { return transitions.size() == 0; }
};

/// All directions from one cell: bin b is about the angle (b + 0.5) 2 pi / bins, counter-clockwise
/// from the x axis of the learned poses.
struct Cell {
  std::vector<AngleBin> bins;

  [[nodiscard]] bool empty() const;
  /// Part of the bins that have something.
  [[nodiscard]] double Filled() const;
  /// Mean over its bins; zero when empty.
  [[nodiscard]] Eigen::Vector2d Place() const;
};

/// A map of colours: what robots without a ceiling camera find their heading by. One file
/// (app/colour_model_file.hpp).
struct ColourModel {
  static constexpr int kVersion = 1;
  ModelKind kind = ModelKind::kVictoria;
  std::vector<ColourClass> classes;
  int bins = 180;  ///< of each cell, 36 .. 720
  GridParams grid;
  std::vector<Cell> cells;  ///< grid.Cells() of them, row by row; one with kSturm
  /// How far away the things are that are seen, as a whole: what moves against what when the robot
  /// is not where it learned. > 0.
  double depth_m = 3.5;
  /// Things learned later weigh more: by e in so many seconds, > 0.
  double fading_s = 600;
  std::int64_t frames = 0;  ///< learned from
  std::string provenance;   ///< command lines, a line each

  /// @throws InputError where anything said above does not hold.
  void Validate() const;
};

/// Certainty of a bin at a later moment: m(f) of ViCTORiA.
double FadedCertainty(const AngleBin& bin, double stamp_s, double fading_s);

/// Adds what another robot learned with the same classes, grid and bins: bin by bin, by certainty.
/// @throws InputError naming what differs.
void Merge(const ColourModel& other, ColourModel& model);

}  // namespace ceilmap::colour
