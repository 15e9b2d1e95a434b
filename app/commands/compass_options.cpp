#include "app/commands/compass_options.hpp"

#include <fmt/format.h>

#include <map>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::commands {
namespace {

const std::map<std::string, labrosse::Method> kMethods = {
    {"fft", labrosse::Method::kFft},
    {"labrosse2006", labrosse::Method::kLabrosse2006},
    {"labrosse2006-probes", labrosse::Method::kLabrosse2006},
    {"labrosse2004", labrosse::Method::kLabrosse2004}};

void RefuseUnlessLabrosse2006(bool given, const char* option, const std::string& method) {
  if (!given || method.starts_with("labrosse2006")) return;
  throw InputError(
      fmt::format("{}: is an option of --method labrosse2006, not of {}; leave one of the two out",
                  option,
                  method));
}

}  // namespace

void CompassOptions::AddTo(CLI::App& cli, const std::string& group) {
  cli.add_option("--method", method, "Method")
      ->check(CLI::IsMember({"fft", "labrosse2006", "labrosse2006-probes", "labrosse2004"}))
      ->capture_default_str()
      ->group(group);
  cli.add_option(
         "--fov",
         fov_deg,
         "Width of the two fields of view, ahead and behind; 180: full circle [by the method]")
      ->type_name("DEG")
      ->group(group);
  cli.add_option("--skip", skip, "labrosse2006: frames left out after each one, \"Fx N\" [none]")
      ->type_name("N")
      ->group(group);
  cli.add_option(
         "--threshold",
         threshold,
         "labrosse2006: normalised amplitude below which the reference is replaced [0.6055]")
      ->type_name("T")
      ->group(group);
}

void CompassOptions::Check() const {
  RefuseUnlessLabrosse2006(skip.has_value(), "--skip", method);
  RefuseUnlessLabrosse2006(threshold.has_value(), "--threshold", method);
  if (fov_deg && method == "labrosse2004") {
    throw InputError("--fov: --method labrosse2004 uses the full circle; leave one of the two out");
  }
  if (fov_deg && !(*fov_deg > 0 && *fov_deg <= 180)) {
    throw InputError(fmt::format("--fov {}: must be > 0 and at most 180 degrees", *fov_deg));
  }
  if (skip && !(*skip >= 0 && *skip <= 1000)) {
    throw InputError(fmt::format("--skip {}: must be in 0..1000", *skip));
  }
  if (skip && threshold) {
    throw InputError(
        "--threshold: with --skip every frame that is used becomes the reference; leave one of the "
        "two out");
  }
  if (threshold && !(*threshold >= 0 && *threshold <= 1)) {
    throw InputError(fmt::format("--threshold {}: must be in 0..1", *threshold));
  }
}

labrosse::CompassParams CompassOptions::Resolve(labrosse::CompassParams params) const {
  Check();
  params.method = kMethods.at(method);
  if (method == "labrosse2006-probes") {
    params.labrosse2006.variant = labrosse::Labrosse2006Variant::kProbes;
  }
  if (fov_deg) {
    const double fov_rad = *fov_deg * kRadPerDeg;
    params.fft.field_of_view_rad = fov_rad;
    params.labrosse2006.field_of_view_rad = fov_rad;
  }
  if (skip) params.labrosse2006.skip = static_cast<int>(*skip);
  if (threshold) params.labrosse2006.threshold = *threshold;
  return params;
}

}  // namespace ceilmap::commands
