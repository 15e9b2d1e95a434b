#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "calib/wheels/relative_motion.hpp"
#include "localization/compass/heading_graph.hpp"
#include "localization/compass/travel_track.hpp"
#include "localization/compass/view_matcher.hpp"

namespace ceilmap::compass {

/// Standard deviation of the error of a heading between two references beyond that stated by the
/// fit, rad.
inline constexpr double kReferenceSigmaRad = 0.001;
/// A reference is replaced when travel has moved the content at the sides by more than this on
/// average, rad, ...
inline constexpr double kMaxParallaxRad = 0.07;
/// ... or when a smaller fraction of the sectors agrees, 0..1.
inline constexpr double kMinInlierRatio = 0.6;

/// The panoramas against which later ones are measured, and their headings: a graph of the turns
/// between them. Internal to FftCompass.
class ReferenceChain {
 public:
  /// A turn from the last reference.
  struct Turn {
    double turn_rad = 0;
    double variance_rad2 = 0;
  };

  explicit ReferenceChain(const FftCompassParams& params) : params_(params) {}

  /// The first reference; its heading is 0.
  void Begin(const std::shared_ptr<View>& first);
  /// Adds a reference. @param known  the same turn by wheels or a gyro, an independent measurement.
  void Add(const std::shared_ptr<View>& view,
           const Turn& turn,
           const std::optional<wheels::RelativeTurn>& known);
  /// Measures the last reference, whose panorama is the current one, relative to recent ones and to
  /// old ones that are similar.
  void Relate(ViewMatcher& matcher, const TravelTrack& travel);
  /// Solves for all headings; of too many references removes every second old one.
  void Settle();

  [[nodiscard]] const std::shared_ptr<View>& LastView() const { return references_.back().view; }
  [[nodiscard]] const HeadingGraph::Place& Last() const { return PlaceOf(references_.back()); }
  [[nodiscard]] std::int64_t Made() const { return made_; }
  /// Measurements relative to a place observed long before.
  [[nodiscard]] std::int64_t Revisits() const { return revisits_; }

 private:
  /// A view with its own heading in the graph.
  struct Reference {
    std::shared_ptr<View> view;
    int place = 0;
  };

  [[nodiscard]] const HeadingGraph::Place& PlaceOf(const Reference& reference) const {
    return graph_.At(reference.place);
  }
  void Measure(const Reference& old,
               ViewMatcher& matcher,
               const std::optional<double>& direction_rad,
               bool revisit);
  void MeasureRevisits(ViewMatcher& matcher);
  void Forget();

  FftCompassParams params_;
  HeadingGraph graph_;
  std::vector<Reference> references_;  // by time; the last one is the current one
  std::int64_t made_ = 0;
  std::int64_t revisits_ = 0;
};

}  // namespace ceilmap::compass
