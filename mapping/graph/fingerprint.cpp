#include "mapping/graph/fingerprint.hpp"

#include <bit>

namespace ceilmap::graph {
namespace {

class Fnv1a {
 public:
  void Add(std::uint64_t value) {
    constexpr std::uint64_t kPrime = 0x100000001b3;
    constexpr unsigned kBytes = 8;
    for (unsigned i = 0; i < kBytes; ++i) {  // the lowest byte first, on every machine
      hash_ = (hash_ ^ ((value >> (8 * i)) & 0xffU)) * kPrime;
    }
  }
  void Add(double value) { Add(std::bit_cast<std::uint64_t>(value)); }
  void Add(const Pose2& pose) {
    Add(pose.x);
    Add(pose.y);
    Add(pose.yaw);
  }
  [[nodiscard]] std::uint64_t Value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace

std::uint64_t Fingerprint(std::span<const Keyframe> keyframes, std::span<const Edge> edges) {
  Fnv1a hash;
  hash.Add(static_cast<std::uint64_t>(keyframes.size()));
  for (const Keyframe& keyframe : keyframes) {
    hash.Add(static_cast<std::uint64_t>(keyframe.id));
    hash.Add(keyframe.pose.T_map_base);
  }
  for (const Edge& edge : edges) {
    hash.Add(static_cast<std::uint64_t>(edge.from));
    hash.Add(static_cast<std::uint64_t>(edge.to));
    hash.Add(static_cast<std::uint64_t>(edge.kind));
    hash.Add(edge.T_from_to);
    for (int row = 0; row < 3; ++row) {
      for (int col = row; col < 3; ++col) hash.Add(edge.information(row, col));
    }
  }
  return hash.Value();
}

}  // namespace ceilmap::graph
