#include "mapping/place_overlap.hpp"

#include "mapping/places/place_descriptor.hpp"
#include "mapping/places/place_index.hpp"

namespace ceilmap::mapping {

namespace {

// Windows of an image that correspond to those of another under one motion: ...
constexpr int kManyWindows = 7;  // ... one such image is enough.
constexpr int kSomeWindows = 5;  // ... kSomeImages of these are enough.
constexpr int kSomeImages = 3;

}  // namespace

bool MayMeet(std::span<const std::int64_t> a,
             std::span<const std::int64_t> b,
             const DescriptorSource& descriptors) {
  places::PlaceIndex index(places::PlaceDescriber::Dimension());
  for (const std::int64_t id : a) index.Add(id, descriptors(id));
  int some = 0;
  for (const std::int64_t id : b) {
    int windows = 0;
    for (const places::PlaceIndex::Match& match : index.Search(descriptors(id), 3)) {
      windows = std::max(windows, match.windows);
    }
    if (windows >= kManyWindows) return true;
    if (windows >= kSomeWindows && ++some >= kSomeImages) return true;
  }
  return false;
}

}  // namespace ceilmap::mapping
