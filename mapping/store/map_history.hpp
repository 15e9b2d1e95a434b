#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ceilmap::store {

/// Outer ring, then the holes, of each polygon, map units; rings are not closed.
using Polygons = std::vector<std::vector<std::vector<cv::Point2d>>>;

/// A recording that a map was made of or updated with.
struct Session {
  std::int64_t id = 0;          ///< 1, 2, 3, ... in order of the updates
  std::string date;             ///< when the map was updated, ISO 8601, UTC
  std::string source;           ///< of the images
  std::string robot;            ///< name in its rig
  std::string program_version;  ///< of the update
  std::int64_t frames = 0;      ///< of the recording
  std::int64_t placed = 0;      ///< of these, with a pose on the map
  /// Whether most of the lamps that the map shows as lit were off, or the opposite.
  bool other_light = false;
  double seen_area = 0;     ///< of the mosaic that was compared, map units^2
  double changed_area = 0;  ///< of that, what had changed
};

/// A part of the ceiling that no longer looks as the map shows it, or looks otherwise under another
/// light.
struct Change {
  enum class Kind {
    kSurface,     ///< another texture: a panel, a banner, an opening
    kBrightness,  ///< only another brightness
    kLamp,        ///< a lamp that is off while most others are on, or new, or moved
    kLight,       ///< a lamp as it looks in other light; no change of the ceiling
  };
  enum class State {
    kCandidate,  ///< seen in one session, in the light of the map; the map is not changed
    kConfirmed,  ///< the map shows the new look; of kLight: known, the map keeps its look
    kReplaced,   ///< confirmed, and changed again since
  };
  std::int64_t id = 0;
  Kind kind = Kind::kSurface;
  State state = State::kCandidate;
  std::int64_t first_session = 0;  ///< in which it was seen first
  std::int64_t last_session = 0;   ///< in which it was seen last
  std::int64_t frames = 0;         ///< images that showed it, in all sessions
  /// Mean share of the variance that differs between what was stored and what is seen, 0..1.
  double difference = 0;
  double area = 0;  ///< map units^2
  Polygons polygons;
};
const char* ToString(Change::Kind kind);
const char* ToString(Change::State state);

/// Part of the mosaic as it looks in another light, where it looks otherwise: lamps that are off at
/// night. Drawn over the mosaic it gives the ceiling in that light.
struct Look {
  static constexpr int kSizePx = 256;
  std::int64_t id = 0;
  std::int64_t session = 0;  ///< the last one that drew into it
  cv::Point origin_px;       ///< upper left corner in the mosaic, multiples of kSizePx
  cv::Mat image;             ///< CV_8UC1, kSizePx square; 0: as in the mosaic
};

/// Most looks of a map: 4 GiB of images, which all users of a map keep in memory.
inline constexpr std::size_t kMaxLooks = std::size_t{1} << 16U;

/// Looks by row and column of their squares.
using LookSquares = std::map<std::pair<int, int>, Look>;
/// Those that show anything, numbered 1, 2, 3, ... @throws RunError for more than kMaxLooks.
std::vector<Look> NumberedLooks(LookSquares squares);

/// What happened to a map since it was made: empty for a map that was never updated.
struct MapHistory {
  std::vector<Session> sessions;  ///< by id
  std::vector<Change> changes;    ///< by id
  std::vector<Look> looks;        ///< by id; of places that differ only
};

}  // namespace ceilmap::store
