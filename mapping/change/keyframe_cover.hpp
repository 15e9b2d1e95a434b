#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::change {

struct KeyframeCoverOptions {
  /// A keyframe is redundant when each place that it shows is shown by so many others; >= 1.
  int min_cover = 2;
  /// And one of these shows at least this share of its image, so that a robot there is recognised
  /// and a later recording joins; 0..1.
  double min_overlap = 0.75;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Which keyframes show what others show too, while some of them are retired. Places are cells of
/// the reference plane, a 24th of the shorter side of an image wide.
class KeyframeCover {
 public:
  /// @param keyframes  of a map; referred to by their index from here on. @param metadata  of it.
  /// @param load  images; called for keyframes that were not level, whose images have margins
  /// without content.
  KeyframeCover(const std::vector<graph::Keyframe>& keyframes,
                const store::MapMetadata& metadata,
                const graph::ImageLoader& load,
                const KeyframeCoverOptions& options = {});

  /// Whether the others cover a keyframe, and also those that were retired before without it.
  [[nodiscard]] bool IsRedundant(std::size_t keyframe) const;
  /// Takes a keyframe out, once.
  void Retire(std::size_t keyframe);

 private:
  void FindOverlaps();

  KeyframeCoverOptions options_;
  std::vector<std::vector<std::int64_t>> cells_;                         // of each keyframe
  std::unordered_map<std::int64_t, std::vector<std::size_t>> shown_by_;  // those not retired
  std::vector<std::vector<std::size_t>> witness_of_;  // the others of which one shows enough
  std::vector<int> kept_witnesses_;                   // those that show enough of a keyframe
  std::vector<bool> retired_;
};

}  // namespace ceilmap::change
