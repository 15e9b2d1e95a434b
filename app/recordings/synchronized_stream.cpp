#include "app/recordings/synchronized_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::recordings {

SynchronizedStream::SynchronizedStream(const std::string& source,
                                       const std::filesystem::path& stamps,
                                       std::string name)
    : SynchronizedStream(
          std::make_unique<FrameSource>(
              source, FrameSourceOptions{.stamps = stamps, .stamps_of_another = true}),
          std::move(name)) {}

SynchronizedStream::SynchronizedStream(std::unique_ptr<FrameSource> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)) {
  Advance();
}

void SynchronizedStream::Advance() {
  Frame frame;
  if (before_) frame.image = std::move(before_->image);  // its memory is used again
  before_ = std::exchange(after_, std::nullopt);
  if (ended_) return;
  try {
    if (source_->Read(frame)) {
      after_ = std::move(frame);
    } else {
      ended_ = true;
    }
  } catch (const InputError& error) {
    damage_ = error.what();
    ended_ = true;
  }
}

cv::Mat SynchronizedStream::At(double stamp_s) {
  const Frame* const frame = Nearest(stamp_s);
  return frame != nullptr ? frame->image : cv::Mat();
}

const Frame* SynchronizedStream::Nearest(double stamp_s) {
  while (after_ && after_->stamp_s <= stamp_s) Advance();
  const Frame* nearest = nullptr;
  double offset_s = 0.05;  // farther away another moment is seen
  for (const std::optional<Frame>* candidate : {&before_, &after_}) {
    if (!*candidate || std::abs((*candidate)->stamp_s - stamp_s) > offset_s) continue;
    nearest = &**candidate;
    offset_s = std::abs(nearest->stamp_s - stamp_s);
  }
  if (nearest == nullptr) {
    ++report_.missing;
    return nullptr;
  }
  ++report_.matched;
  report_.largest_offset_s = std::max(report_.largest_offset_s, offset_s);
  return nearest;
}

SynchronizedStream::Report SynchronizedStream::GetReport() const {
  Report report = report_;
  report.reading = source_->Report();
  return report;
}

std::vector<std::string> SynchronizedStream::Warnings() const {
  std::vector<std::string> warnings = source_->Warnings();
  if (!damage_.empty()) warnings.push_back(damage_ + "; it is not used from there on");
  const std::int64_t all = report_.matched + report_.missing;
  if (report_.missing > 0) {
    warnings.push_back(fmt::format("{}: {} of {} upward frames have no {} frame at their time",
                                   Name(),
                                   report_.missing,
                                   all,
                                   name_));
  }
  constexpr double kNotableS = 1e-3;
  if (report_.largest_offset_s > kNotableS) {
    warnings.push_back(fmt::format("{}: its frames were matched by time, up to {:.0f} ms apart",
                                   Name(),
                                   1e3 * report_.largest_offset_s));
  }
  return warnings;
}

}  // namespace ceilmap::recordings
