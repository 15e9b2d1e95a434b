#pragma once

#include <Eigen/Core>
#include <vector>

#include "samples/simulator/random.hpp"
#include "samples/simulator/solid.hpp"
#include "samples/simulator/structure.hpp"

namespace ceilmap::simulator {

/// One run of a structure while it is built. Positions are (s, c, z): along the run, across it,
/// above the floor; s is x of map and c is y, or the other way round for a run along y.
class StructureRun {
 public:
  /// @param across_m  c of the run's middle. @param objects  Receives the solids and points.
  StructureRun(const Structure& structure,
               double across_m,
               double ceiling_m,
               Random& random,
               Objects& objects);

  [[nodiscard]] const Structure& Of() const { return structure_; }
  [[nodiscard]] double Across() const { return across_m_; }
  [[nodiscard]] Random& Dice() { return random_; }
  [[nodiscard]] Eigen::Vector3d InMap(double s, double c, double z) const;

  /// A box parallel to the run, with random differences in its light of a few percent.
  void Block(double s0, double s1, double c0, double c1, double z0, double z1, double brightness);
  void BarInMap(const Eigen::Vector3d& from_map,
                const Eigen::Vector3d& to_map,
                double width_m,
                double depth_m,
                double brightness);
  /// A bar between the centres of its ends.
  void Beam(const Eigen::Vector3d& from,
            const Eigen::Vector3d& to,
            double width_m,
            double depth_m,
            double brightness);
  void Cylinder(const Eigen::Vector3d& from,
                const Eigen::Vector3d& to,
                double diameter_m,
                double brightness);
  /// A thin rod from a height to the ceiling.
  void Hanger(double s, double c, double z);
  void Point(double s, double c, double z);

 private:
  void Add(Solid solid, double brightness);

  const Structure& structure_;
  double across_m_;
  double ceiling_m_;
  Random& random_;
  Objects& objects_;
};

/// Positions between s0 and s1 at equal distances > 0, the first one half a distance from s0.
std::vector<double> PlacesBetween(double s0, double s1, double every_m);

/// Builds a run of a truss, duct, round duct, tray or pipe from s0 to s1.
void BuildContinuous(StructureRun& run, double s0, double s1);
/// Builds a pendant, tube or skylight with its centre at s.
void BuildSingle(StructureRun& run, double s);

}  // namespace ceilmap::simulator
