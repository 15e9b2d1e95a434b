#include "tests/faults/motion_faults.hpp"

#include <functional>
#include <numbers>
#include <sstream>
#include <utility>
#include <vector>

namespace ceilmap::faults {
namespace {

using simulator::GyroSample;
using simulator::WheelSample;

std::size_t RandomIndex(std::size_t count, Random& random) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
}

double Between(double low, double high, Random& random) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Changes the motion between each two samples, and integrates it again.
// @param change  (index of the second sample, T_before_base)
Motion Reintegrate(const Motion& good, const std::function<Pose2(std::size_t, Pose2)>& change) {
  Motion faulty = good;
  for (std::size_t i = 1; i < good.wheels.size(); ++i) {
    const WheelSample& before = good.wheels[i - 1];
    WheelSample& sample = faulty.wheels[i];
    const Pose2 moved = before.T_odom_base.Inverse() * sample.T_odom_base;
    const Pose2 changed = change(i, moved);
    const double seconds = sample.stamp_s - before.stamp_s;
    sample.T_odom_base = faulty.wheels[i - 1].T_odom_base * changed;
    sample.v_m_s += (changed.x - moved.x) / seconds;
    sample.omega_rad_s += (changed.yaw - moved.yaw) / seconds;
  }
  return faulty;
}

}  // namespace

Motion MissingWheels(const Motion& good, double share, Random& random) {
  Motion faulty = good;
  const auto count = static_cast<std::size_t>(share * static_cast<double>(good.wheels.size()));
  const auto first = static_cast<std::ptrdiff_t>(RandomIndex(good.wheels.size() - count, random));
  faulty.wheels.erase(faulty.wheels.begin() + first,
                      faulty.wheels.begin() + first + static_cast<std::ptrdiff_t>(count));
  return faulty;
}

Motion SlippingWheels(const Motion& good, int times, double extra_m, Random& random) {
  constexpr double kSeconds = 0.5;
  std::vector<double> begins;
  begins.reserve(static_cast<std::size_t>(times));
  for (int i = 0; i < times; ++i) {
    begins.push_back(good.wheels[RandomIndex(good.wheels.size(), random)].stamp_s);
  }
  return Reintegrate(good, [&](std::size_t i, Pose2 moved) {
    const double stamp_s = good.wheels[i].stamp_s;
    const double seconds = stamp_s - good.wheels[i - 1].stamp_s;
    for (const double begin_s : begins) {
      if (stamp_s > begin_s && stamp_s <= begin_s + kSeconds) {
        moved.x += extra_m * seconds / kSeconds;
      }
    }
    return moved;
  });
}

Motion WrongClock(const Motion& good, double offset_s) {
  Motion faulty = good;
  for (WheelSample& sample : faulty.wheels) sample.stamp_s += offset_s;
  for (GyroSample& sample : faulty.gyro) sample.stamp_s += offset_s;
  return faulty;
}

Motion OppositeTurns(const Motion& good) {
  return Reintegrate(good, [](std::size_t, const Pose2& moved) {
    return Pose2{moved.x, -moved.y, -moved.yaw};
  });
}

Motion OppositeMotion(const Motion& good) {
  return Reintegrate(good, [](std::size_t, const Pose2& moved) {
    return Pose2{-moved.x, -moved.y, -moved.yaw};
  });
}

Motion WrongScale(const Motion& good, double factor) {
  return Reintegrate(good, [=](std::size_t, const Pose2& moved) {
    return Pose2{factor * moved.x, factor * moved.y, moved.yaw};
  });
}

Motion JumpingPoses(const Motion& good, int jumps, Random& random) {
  std::vector<std::size_t> at;
  at.reserve(static_cast<std::size_t>(jumps));
  for (int i = 0; i < jumps; ++i) at.push_back(1 + RandomIndex(good.wheels.size() - 1, random));
  Motion faulty = good;
  for (const std::size_t first : at) {
    const Pose2 jump{Between(-2, 2, random),
                     Between(-2, 2, random),
                     Between(-std::numbers::pi, std::numbers::pi, random)};
    for (std::size_t i = first; i < good.wheels.size(); ++i) {
      faulty.wheels[i].T_odom_base = jump * faulty.wheels[i].T_odom_base;
    }
  }
  return faulty;
}

Motion ShuffledRows(const Motion& good, double share, Random& random) {
  Motion faulty;
  faulty.wheels.reserve(2 * good.wheels.size());
  for (const WheelSample& sample : good.wheels) {
    faulty.wheels.push_back(sample);
    if (Between(0, 1, random) < share) faulty.wheels.push_back(sample);
  }
  for (std::size_t i = 1; i < faulty.wheels.size(); ++i) {
    if (Between(0, 1, random) < share) std::swap(faulty.wheels[i - 1], faulty.wheels[i]);
  }
  faulty.gyro = good.gyro;
  for (std::size_t i = 1; i < faulty.gyro.size(); ++i) {
    if (Between(0, 1, random) < share) std::swap(faulty.gyro[i - 1], faulty.gyro[i]);
  }
  return faulty;
}

Motion OppositeGyro(const Motion& good) {
  Motion faulty = good;
  for (GyroSample& sample : faulty.gyro) sample.omega_z_rad_s *= -1;
  return faulty;
}

Motion StuckGyro(const Motion& good, Random& random) {
  Motion faulty = good;
  const std::size_t first = RandomIndex(good.gyro.size() / 2, random);
  for (std::size_t i = first; i < faulty.gyro.size(); ++i) {
    faulty.gyro[i].omega_z_rad_s = good.gyro[first].omega_z_rad_s;
  }
  return faulty;
}

Motion GyroInDegrees(const Motion& good) {
  Motion faulty = good;
  for (GyroSample& sample : faulty.gyro) sample.omega_z_rad_s *= 180 / std::numbers::pi;
  return faulty;
}

std::string ReplaceLines(const std::string& text,
                         int lines,
                         const std::string& replacement,
                         Random& random) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) all.push_back(line);
  for (int i = 0; i < lines; ++i) all[1 + RandomIndex(all.size() - 1, random)] = replacement;
  std::string changed;
  for (const std::string& line : all) changed += line + '\n';
  return changed;
}

}  // namespace ceilmap::faults
