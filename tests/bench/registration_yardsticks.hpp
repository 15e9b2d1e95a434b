#pragma once

#include <benchmark/benchmark.h>

/// What registration is measured against, on the same frames (registration_frames.hpp).
namespace ceilmap::bench {

/// The Fourier transforms that registration cannot do without, by measured plans of FFTW; only
/// where FFTW is the library of the transforms (CEILMAP_FFTW).
void TransformsAlone(benchmark::State& state);
/// The coarse method put together from OpenCV's functions.
void OpenCv(benchmark::State& state);
/// Feature matching.
void Orb(benchmark::State& state);

}  // namespace ceilmap::bench
