#pragma once

#include <cstdint>
#include <vector>

namespace ceilmap::compass {

/// Headings of places of which some are known relative to each other: linear least squares on the
/// circle, exact, in one dimension. The first place is 0 by definition.
class HeadingGraph {
 public:
  struct Place {
    double heading_rad = 0;
    double variance_rad2 = 0;  ///< relative to the first place
  };

  /// Adds a place with a first guess of its heading. @return its number, counted from 0.
  int Add(double heading_rad);
  /// heading(to) - heading(from) was measured. @param variance_rad2  > 0.
  void Measure(int from, int to, double turn_rad, double variance_rad2);
  /// Brings all headings to the optimum. A place that nothing ties to the first one keeps its
  /// heading relative to its neighbours.
  void Solve();
  /// Takes a place out; what it told of others is kept in measurements between its neighbours,
  /// exactly. The first place stays. Numbers of the others stay the same, its own is free again.
  void Remove(int place);

  [[nodiscard]] const Place& At(int place) const {
    return places_[static_cast<std::size_t>(place)];
  }
  [[nodiscard]] int Size() const { return size_; }

 private:
  struct Turn {
    int from;
    int to;
    double turn_rad;
    double information;
  };
  std::vector<Place> places_;
  std::vector<bool> used_;
  std::vector<Turn> turns_;
  int size_ = 0;
};

}  // namespace ceilmap::compass
