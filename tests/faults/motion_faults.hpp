#pragma once

#include <string>

#include "tests/faults/motion.hpp"

/// What can go wrong with the wheels and the gyro of a drive, one function each, as
/// recording_faults.hpp.
namespace ceilmap::faults {

/// The wheels report nothing for this share of the drive, from a random moment on.
Motion MissingWheels(const Motion& good, double share, Random& random);
/// Both wheels turn on the spot this number of times, at random moments of the drive, and show
/// `extra_m` of travel each time, within half a second.
Motion SlippingWheels(const Motion& good, int times, double extra_m, Random& random);
/// All stamps of wheels and gyro are later by this time.
Motion WrongClock(const Motion& good, double offset_s);
/// The wheels report the opposite of each turn.
Motion OppositeTurns(const Motion& good);
/// The wheels report the opposite of all motion: a robot that was mounted the other way round.
Motion OppositeMotion(const Motion& good);
/// The wheels report this multiple of the travel.
Motion WrongScale(const Motion& good, double factor);
/// The pose of the odometry jumps this number of times at random moments, by up to 2 m and any
/// angle: an odometry that is corrected by something else, or begins anew.
Motion JumpingPoses(const Motion& good, int jumps, Random& random);
/// This share of the rows of wheels and gyro comes twice, or in the wrong order.
Motion ShuffledRows(const Motion& good, double share, Random& random);

/// The gyro reports the opposite of each turn.
Motion OppositeGyro(const Motion& good);
/// The gyro keeps its last value from a random moment on.
Motion StuckGyro(const Motion& good, Random& random);
/// The gyro reports degrees per second as if they were radians.
Motion GyroInDegrees(const Motion& good);

/// This number of random lines, not the first, is replaced by a text.
std::string ReplaceLines(const std::string& text,
                         int lines,
                         const std::string& replacement,
                         Random& random);

}  // namespace ceilmap::faults
