#include "app/recordings/bag_frames.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/bags/image_decoding.hpp"
#include "app/bags/message_error.hpp"
#include "app/bags/message_types.hpp"
#include "app/bags/messages.hpp"
#include "app/recordings/images.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {

BagFrames::BagFrames(std::unique_ptr<BagStream> stream, Pixels pixels, BagStamp stamp)
    : stream_(std::move(stream)), pixels_(pixels), times_(stamp) {}

std::optional<std::int64_t> BagFrames::ExpectedFrames() const {
  return stream_->Topic().messages;
}

std::optional<double> BagFrames::FramePeriod() const {
  const bags::BagFacts& facts = stream_->Recording().Facts();
  const std::int64_t messages = stream_->Topic().messages.value_or(0);
  if (messages < 2 || !facts.first_ns || !facts.last_ns) return std::nullopt;
  const double period_s =
      SecondsOf(*facts.last_ns - *facts.first_ns) / static_cast<double>(messages - 1);
  return period_s > 0 ? std::optional(period_s) : std::nullopt;
}

// @return the stamp of the header. @throws bags::MessageError
std::int64_t BagFrames::Decode(cv::Mat& image) {
  const bags::MessageEncoding encoding = stream_->Topic().encoding;
  const bool colour = pixels_ == Pixels::kColour;
  if (stream_->Topic().type == bags::kCompressedImageType) {
    const auto message = bags::DecodeCompressedImage(message_.data, encoding);
    bags::DecodePixels(message, colour, image);
    return message.header.stamp_ns;
  }
  const auto message = bags::DecodeImage(message_.data, encoding);
  bags::DecodePixels(message, colour, image);
  return message.header.stamp_ns;
}

bool BagFrames::Next(cv::Mat& image, std::optional<double>& time_s) {
  while (stream_->Next(message_)) {
    try {
      const std::int64_t header_ns = Decode(image);
      CheckImageSize(image.size(), stream_->Recording().Name());
      const std::optional<std::int64_t> stamp_ns = times_.Of(header_ns, message_.log_time_ns);
      if (!stamp_ns) continue;
      time_s = SecondsOf(*stamp_ns);
      ++frames_;
      return true;
    } catch (const bags::MessageError& error) {
      if (frames_ == 0) {
        throw InputError(fmt::format("{}: {} at {:.3f} s: {}",
                                     stream_->Recording().Name(),
                                     Part(),
                                     SecondsOf(message_.log_time_ns),
                                     error.what()));
      }
      ++left_out_;
    }
  }
  return false;
}

std::vector<std::string> BagFrames::EndRemarks() {
  std::vector<std::string> remarks = stream_->Recording().TakeWarnings();
  if (times_.Late() > 0) {
    remarks.push_back(
        fmt::format("{}: {} images of {} were recorded after later ones, and were "
                    "left out",
                    stream_->Recording().Name(),
                    times_.Late(),
                    stream_->Topic().name));
  }
  if (times_.Replaced() > 0) {
    remarks.push_back(
        fmt::format("{}: {} of {} headers of {} have no time, or none that is later than that of "
                    "the frame before; the times of the recording are used there (--stamp log: "
                    "everywhere)",
                    stream_->Recording().Name(),
                    times_.Replaced(),
                    frames_,
                    Part()));
  }
  return remarks;
}

std::unique_ptr<FrameReader> OpenBagFrames(const std::string& bag,
                                           const BagTopic& topic,
                                           Pixels pixels) {
  return std::make_unique<BagFrames>(OpenTopic(bag, topic, TopicUse::kImages), pixels, topic.stamp);
}

}  // namespace ceilmap::recordings
