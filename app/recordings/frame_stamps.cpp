#include "app/recordings/frame_stamps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/files/stamps.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

StampOrigin OriginFor(bool have_file, FrameReader::Kind kind) {
  if (have_file) return StampOrigin::kStampsFile;
  switch (kind) {
    case FrameReader::Kind::kImages:
      return StampOrigin::kFrameIndex;
    case FrameReader::Kind::kLive:
      return StampOrigin::kClock;
    default:
      return StampOrigin::kContainer;
  }
}

}  // namespace

FrameStamps::FrameStamps(std::string source, const std::filesystem::path& file, bool of_another)
    : source_(std::move(source)), file_(file.string()), of_another_(of_another) {
  if (!file.empty()) stamps_s_ = files::ReadStamps(file);
}

// A container's count may be an estimate, so the frames are counted before stamps are refused.
std::optional<std::string> FrameStamps::Begin(const FrameReader& reader,
                                              std::optional<std::int64_t>& expected) {
  const FrameReader::Kind kind = reader.GetKind();
  origin_ = OriginFor(!stamps_s_.empty(), kind);
  if (stamps_s_.empty() || !expected) return std::nullopt;
  const auto stamps = static_cast<std::int64_t>(stamps_s_.size());
  if (stamps == *expected) return std::nullopt;
  const bool is_video = kind == FrameReader::Kind::kVideo;
  if (is_video && !reader.CanStall() && !reader.CountsExactly()) expected = CountFrames(source_);
  if (stamps == *expected) return std::nullopt;
  if (!of_another_) CheckEnd(*expected);
  return UseOwnTime(is_video, *expected);
}

// Images without their own stamps use the given stamps as far as these go.
std::string FrameStamps::UseOwnTime(bool has_time, std::int64_t frames) {
  std::string warning =
      fmt::format("{} has {} frames, {} {} stamps: {}",
                  source_,
                  frames,
                  file_,
                  stamps_s_.size(),
                  has_time ? "the video's own time is used, starting at the first stamp"
                           : "the first stamp belongs to the first frame");
  if (has_time) {
    origin_ = StampOrigin::kContainer;
    first_s_ = stamps_s_.front();
  }
  stamps_s_.resize(has_time ? 0 : std::min<std::size_t>(stamps_s_.size(), frames));
  return warning;
}

bool FrameStamps::EndBefore(std::int64_t index) const {
  return origin_ == StampOrigin::kStampsFile && of_another_ &&
         static_cast<std::size_t>(index) >= stamps_s_.size();
}

double FrameStamps::Of(std::int64_t index, const std::optional<double>& time_s, double period_s) {
  if (origin_ == StampOrigin::kFrameIndex) return static_cast<double>(index);
  if (origin_ == StampOrigin::kStampsFile) {
    if (static_cast<std::size_t>(index) >= stamps_s_.size()) {
      throw InputError(
          fmt::format("{}: {} stamps, but {} has more frames", file_, stamps_s_.size(), source_));
    }
    return stamps_s_[static_cast<std::size_t>(index)];
  }
  // The first frames of some streams have no time: the others follow them.
  const bool first_time = time_s && missing_ == index;
  if (first_time && index > 0) first_s_ = std::max(first_s_, last_s_ + period_s - *time_s);
  double stamp_s = first_s_ + time_s.value_or(0);
  if (!time_s) ++missing_;
  // Some containers repeat or lose times, but stamps must increase.
  if (index > 0 && stamp_s <= last_s_) {
    if (time_s) ++wrong_;
    stamp_s = last_s_ + period_s;
  }
  last_s_ = stamp_s;
  return stamp_s;
}

bool FrameStamps::AllOfAnotherUsed(std::int64_t frames) const {
  return of_another_ && static_cast<std::size_t>(frames) >= stamps_s_.size();
}

void FrameStamps::CheckEnd(std::int64_t frames) const {
  const auto stamps = static_cast<std::int64_t>(stamps_s_.size());
  if (stamps == 0 || of_another_ || stamps == frames) return;
  throw InputError(fmt::format("{}: {} stamps, but {} has {} frames; give one line per frame",
                               file_,
                               stamps,
                               source_,
                               frames));
}

std::vector<std::string> FrameStamps::Warnings(std::int64_t frames, double period_s) const {
  std::vector<std::string> warnings;
  if (2 * missing_ > frames) {
    warnings.push_back(fmt::format(
        "{}: its frames have no time stamps and are taken to be {:.6g} s apart; see --stamps",
        source_,
        period_s));
  }
  if (wrong_ > 0) {
    warnings.push_back(fmt::format(
        "{}: the time of {} frames was not later than that of the frame before; each was put "
        "{:.6g} s after it",
        source_,
        wrong_,
        period_s));
  }
  return warnings;
}

}  // namespace ceilmap::recordings
