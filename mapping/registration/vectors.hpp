#pragma once

#include <array>
#include <cstdint>
#include <cstring>

/// Part of each version of a CEILMAP_HOT function, instead of one plain version for all of them.
#define CEILMAP_INLINE __attribute__((always_inline)) inline

/// Vectors of GCC and Clang, which become the registers that the machine has. The wide ones are
/// passed by reference, because in registers they would need the newest instructions everywhere.
namespace ceilmap::registration::kernels {

using Four = float __attribute__((vector_size(16)));
using FourInt = std::int32_t __attribute__((vector_size(16)));
using Eight = float __attribute__((vector_size(32)));
using EightInt = std::int32_t __attribute__((vector_size(32)));

CEILMAP_INLINE Four Load(const float* p) {
  Four v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

CEILMAP_INLINE void Load(const float* p, Eight& v) {
  std::memcpy(&v, p, sizeof v);
}

CEILMAP_INLINE void Lanes(Eight& out) {
  out = __builtin_convertvector(EightInt{0, 1, 2, 3, 4, 5, 6, 7}, Eight);
}

/// Sums of four vectors, one in each lane.
CEILMAP_INLINE Four SumsOf(Four a, Four b, Four c, Four d) {
  const Four ab =
      __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Four cd =
      __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

CEILMAP_INLINE float Sum(const Four& v) {
  return v[0] + v[1] + v[2] + v[3];
}

CEILMAP_INLINE float Sum(const Eight& v) {
  return Sum(__builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7));
}

using Tile = std::array<Eight, 8>;

/// Exchanges rows and columns.
CEILMAP_INLINE void Transpose(Tile& t) {
  Tile a;
  for (std::size_t i = 0; i < 8; i += 2) {
    a[i] = __builtin_shufflevector(t[i], t[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    a[i + 1] = __builtin_shufflevector(t[i], t[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  Tile b;
  for (const std::size_t i : {0, 1, 4, 5}) {
    b[i] = __builtin_shufflevector(a[i], a[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
    b[i + 2] = __builtin_shufflevector(a[i], a[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    t[i] = __builtin_shufflevector(b[i], b[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    t[i + 4] = __builtin_shufflevector(b[i], b[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

CEILMAP_INLINE void Reverse(Eight& v) {
  v = __builtin_shufflevector(v, v, 7, 6, 5, 4, 3, 2, 1, 0);
}

}  // namespace ceilmap::registration::kernels
