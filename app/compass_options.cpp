#include "app/compass_options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "calib/error.hpp"
#include "calib/pose2.hpp"
#include "localization/compass/column_shift.hpp"

namespace ceilmap::app {
namespace {

using compass::DistanceProfile;
using compass::HeadingEstimate;
using compass::PanoramaFrame;

// Stands in until localization/compass/ has its factory: whole columns, from frame to frame.
class FrameToFrameCompass final : public compass::Compass {
 public:
  explicit FrameToFrameCompass(std::int64_t skip) : skip_(skip) {}

  std::optional<HeadingEstimate> Next(const PanoramaFrame& frame) override {
    const std::int64_t index = frames_++;
    if (index % (skip_ + 1) != 0) return std::nullopt;
    if (index > 0) {
      const auto shift = compass::FindColumnShift(current_, frame.panorama);
      const double column_rad = 2 * std::numbers::pi / frame.panorama.cols;
      estimate_.confidence = shift ? 1 : 0;
      estimate_.variance_rad2 += (shift ? 0.1 : 10) * column_rad * column_rad;
      shift_columns_ = shift ? shift->columns : 0;
      if (shift) {
        estimate_.heading_rad = calib::WrapAngle(estimate_.heading_rad + shift->heading_change_rad);
      }
    } else {
      estimate_.confidence = 1;
    }
    cv::swap(reference_, current_);
    frame.panorama.copyTo(current_);
    reference_index_ = current_index_;
    current_index_ = index;
    return estimate_;
  }

  [[nodiscard]] DistanceProfile Profile() const override {
    DistanceProfile profile;
    if (reference_.empty()) return profile;
    for (const auto squared : compass::SquaredShiftDistances(reference_, current_)) {
      profile.distance.push_back(std::sqrt(static_cast<double>(squared)));
    }
    profile.shift_columns = shift_columns_;
    profile.reference_frame = reference_index_;
    return profile;
  }

  [[nodiscard]] std::int64_t References() const override {
    return current_.empty() ? 0 : (frames_ + skip_) / (skip_ + 1);
  }

 private:
  std::int64_t skip_;
  std::int64_t frames_ = 0;
  cv::Mat reference_;
  cv::Mat current_;
  std::int64_t reference_index_ = 0;
  std::int64_t current_index_ = 0;
  int shift_columns_ = 0;
  HeadingEstimate estimate_;
};

void RefuseUnlessLabrosse2006(bool given, const char* option, const std::string& method) {
  if (!given || method == "labrosse2006") return;
  throw calib::InputError(fmt::format(
      "{}: is of --method labrosse2006, not of {}; leave one of the two out", option, method));
}

}  // namespace

void CompassOptions::AddTo(CLI::App& cli, const std::string& group) {
  cli.add_option("--method", method, "How headings are found")
      ->check(CLI::IsMember({"fft", "labrosse2006", "labrosse2004"}))
      ->capture_default_str()
      ->group(group);
  cli.add_option(
         "--fov",
         fov_deg,
         "Width of the two fields of view, ahead and behind; 180: all around [the method's]")
      ->type_name("DEG")
      ->group(group);
  cli.add_option("--skip", skip, "labrosse2006: frames left out after each one, \"Fx N\" [none]")
      ->type_name("N")
      ->group(group);
  cli.add_option(
         "--threshold",
         threshold,
         "labrosse2006: the normalised amplitude below which the reference changes [0.6055]")
      ->type_name("T")
      ->group(group);
}

void CompassOptions::Check() const {
  RefuseUnlessLabrosse2006(skip.has_value(), "--skip", method);
  RefuseUnlessLabrosse2006(threshold.has_value(), "--threshold", method);
  if (fov_deg && method == "labrosse2004") {
    throw calib::InputError(
        "--fov: --method labrosse2004 looks all around; leave one of the two out");
  }
  if (fov_deg && !(*fov_deg > 0 && *fov_deg <= 180)) {
    throw calib::InputError(fmt::format("--fov {}: must be > 0 and at most 180 degrees", *fov_deg));
  }
  if (skip && !(*skip >= 0 && *skip <= 1000)) {
    throw calib::InputError(fmt::format("--skip {}: must be in 0..1000", *skip));
  }
  if (threshold && !(*threshold >= 0 && *threshold <= 1)) {
    throw calib::InputError(fmt::format("--threshold {}: must be in 0..1", *threshold));
  }
}

std::unique_ptr<compass::Compass> CompassOptions::Make() const {
  Check();
  return std::make_unique<FrameToFrameCompass>(skip.value_or(0));
}

}  // namespace ceilmap::app
