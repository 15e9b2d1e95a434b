#pragma once

#include <cstdint>
#include <vector>

namespace ceilmap::compass {

/// Headings of places, some of which were measured relative to each other: linear least squares on
/// the circle, exact, in one dimension. The first place has heading 0 by definition.
class HeadingGraph {
 public:
  struct Place {
    double heading_rad = 0;
    double variance_rad2 = 0;  ///< relative to the first place
  };

  /// Adds a place with an initial estimate of its heading. @return its number, counted from 0.
  int Add(double heading_rad);
  /// Adds a measurement of heading(to) - heading(from). @param variance_rad2  > 0.
  void Measure(int from, int to, double turn_rad, double variance_rad2);
  /// Optimizes all headings. A place that is not connected to the first one keeps its heading
  /// relative to its neighbours.
  void Solve();
  /// Removes a place by marginalization: its information about other places is kept exactly, in
  /// measurements between its neighbours. The first place cannot be removed. The numbers of the
  /// other places stay the same; the number of the removed place becomes free.
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
