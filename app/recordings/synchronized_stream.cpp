#include "app/recordings/synchronized_stream.hpp"

#include <fmt/format.h>

#include <optional>

namespace ceilmap::recordings {
namespace {

constexpr double kMaxOffsetS = 0.05;  // as robot::SensorsParams::max_offset_s

}  // namespace

std::vector<std::string> MatchWarnings(const std::string& source,
                                       const std::string& camera,
                                       const robot::StreamReport& matches) {
  std::vector<std::string> warnings;
  if (matches.missing > 0) {
    warnings.push_back(fmt::format("{}: {} of {} upward frames have no {} frame at their time",
                                   source,
                                   matches.missing,
                                   matches.matched + matches.missing,
                                   camera));
  }
  constexpr double kNotableS = 1e-3;
  if (matches.largest_offset_s > kNotableS) {
    warnings.push_back(fmt::format("{}: its frames were matched by time, up to {:.0f} ms apart",
                                   source,
                                   1e3 * matches.largest_offset_s));
  }
  return warnings;
}

SynchronizedStream::SynchronizedStream(const std::string& source,
                                       const std::filesystem::path& stamps,
                                       const BagTopic& bag)
    : stream_(source, stamps, Pixels::kGrey, bag), images_(kMaxOffsetS) {}

cv::Mat SynchronizedStream::At(double stamp_s) {
  stream_.ReadTo(stamp_s, [this](const robot::Image& image) { images_.Add(image); });
  const std::optional<robot::Image> nearest = images_.Nearest(stamp_s);
  return nearest ? nearest->pixels : cv::Mat();
}

std::vector<std::string> SynchronizedStream::Warnings() const {
  std::vector<std::string> warnings = stream_.Warnings();
  for (std::string& warning : MatchWarnings(Name(), "forward", images_.Report())) {
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

}  // namespace ceilmap::recordings
