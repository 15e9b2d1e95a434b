#pragma once

#include "tests/faults/recording.hpp"

/// What can go wrong with a recording, one function each. All of them are deterministic for a state
/// of the random numbers, and leave the recording that they are given alone. Stamps stay honest
/// unless the function says otherwise: each is the moment at which that image was taken.
namespace ceilmap::faults {

/// Leaves out this share of the frames, at random, in [0, 1); the first stays.
Recording DropFrames(const Recording& good, double share, Random& random);
/// This share of the frames comes twice, the second time with a stamp of its own half a period
/// later: a driver that repeats its buffer.
Recording DuplicateFrames(const Recording& good, double share, Random& random);
/// This share of the frames is exchanged with the one behind it; stamps stay where they were, so
/// that those of exchanged frames are wrong by a period.
Recording SwapFrames(const Recording& good, double share, Random& random);

/// Every other image is darker: grey values times `low`.
Recording Flicker(const Recording& good, double low);
/// From each of this number of random frames on, another exposure: grey values times 0.35 to 2.5.
Recording ExposureJumps(const Recording& good, int jumps, Random& random);
/// Images of this share of frames are smeared over `length_px` pixels in a random direction.
Recording MotionBlur(const Recording& good, double share, int length_px, Random& random);
/// This share of all pixels is black or white, others in each image.
Recording SaltNoise(const Recording& good, double share, Random& random);
/// This number of rows of the sensor are dead, the same in all images: black or white.
Recording DeadRows(const Recording& good, int rows, Random& random);
/// From the middle of the recording on, half the lens is covered: dark, out of focus.
Recording CoveredHalf(const Recording& good);
/// A third of the recording shows nothing: black.
Recording Dark(const Recording& good);

}  // namespace ceilmap::faults
