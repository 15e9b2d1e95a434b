// Readers of what a robot's other sensors and settings are: odometry, gyro, hypotheses, parameters.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "app/files/csv.hpp"
#include "app/files/hypotheses_csv.hpp"
#include "app/files/odometry_csv.hpp"
#include "calib/base/settings.hpp"
#include "calib/wheels/dead_reckoning.hpp"
#include "mapping/mapper_settings.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

template <typename Samples>
void RequireOrder(const Samples& samples) {
  double before_s = -std::numeric_limits<double>::infinity();
  for (const auto& sample : samples) {
    Require(std::isfinite(sample.stamp_s) && sample.stamp_s > before_s, "samples out of order");
    before_s = sample.stamp_s;
  }
}

// The motion of the last second.
void RequireFinite(const wheels::DeadReckoning& reckoning, double first_s, double last_s) {
  const auto motion = reckoning.Between(std::max(first_s, last_s - 1), last_s);
  if (!motion) return;
  const Pose2& moved = motion->T_before_now;
  Require(moved.Translation().allFinite() && std::isfinite(moved.yaw) &&
              motion->Covariance().allFinite(),
          "a motion that is not finite");
}

}  // namespace

void ReadAsOdometry(std::string_view bytes) {
  const auto read =
      Accepted([&] { return files::ParseOdometry(std::string(bytes), "odometry.csv"); });
  if (!read) return;
  Require(read->poses.empty() != read->speeds.empty(), "both poses and speeds");
  Require(read->poses.size() + read->speeds.size() >= 1 && read->out_of_order >= 0, "no samples");
  RequireOrder(read->poses);
  RequireOrder(read->speeds);
  Require(read->FirstStamp() <= read->LastStamp(), "it ends before it begins");
  (void)Accepted([&] {
    wheels::DeadReckoning reckoning;
    for (const wheels::OdometrySample& sample : read->poses) reckoning.Add(sample);
    for (const wheels::WheelSpeedSample& sample : read->speeds) reckoning.Add(sample);
    RequireFinite(reckoning, read->FirstStamp(), read->LastStamp());
    return 0;
  });
}

void ReadAsGyro(std::string_view bytes) {
  const auto read = Accepted([&] { return files::ParseGyro(std::string(bytes), "gyro.csv"); });
  if (!read) return;
  Require(!read->samples.empty() && read->out_of_order >= 0, "no samples");
  RequireOrder(read->samples);
  // Beside wheels that stand.
  const double first_s = read->samples.front().stamp_s;
  const double last_s = read->samples.back().stamp_s;
  (void)Accepted([&] {
    wheels::DeadReckoning reckoning;
    reckoning.Add(wheels::OdometrySample{first_s, {}});
    for (const wheels::GyroSample& sample : read->samples) reckoning.Add(sample);
    if (last_s > first_s) reckoning.Add(wheels::OdometrySample{last_s, {}});
    RequireFinite(reckoning, first_s, last_s);
    return 0;
  });
}

void ReadAsHypotheses(std::string_view bytes) {
  const auto table = Accepted([&] { return files::ParseCsv(bytes, "hypotheses.csv"); });
  if (!table) return;
  const auto read = Accepted([&] { return files::HypothesesIn(*table); });
  if (!read) return;
  RequireOrder(*read);
  std::size_t places = 0;
  for (const files::StampedHypotheses& moment : *read) {
    places += moment.places.size();
    for (const WeightedPose& place : moment.places) {
      Require(place.weight > 0 && place.pose.Translation().allFinite(), "a place that cannot be");
    }
  }
  Require(places == table->rows.size(), "places are lost");
}

void ReadAsSettings(std::string_view bytes) {
  mapping::MapperParams params;
  const Settings settings;
  mapping::Describe(params, settings.In("mapping"));
  const auto text = Accepted([&] {
    settings.Parse(std::string(bytes), "settings.yaml");
    return FormatSettingsFile(settings);
  });
  if (!text) return;
  settings.Parse(*text, "again.yaml");
  Require(FormatSettingsFile(settings) == *text, "settings read back as other ones");
}

}  // namespace ceilmap::fuzz
