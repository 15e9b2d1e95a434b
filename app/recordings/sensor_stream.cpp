#include "app/recordings/sensor_stream.hpp"

#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::recordings {

SensorStream::SensorStream(const std::string& source,
                           const std::filesystem::path& stamps,
                           Pixels pixels,
                           const BagTopic& bag)
    : SensorStream(std::make_unique<FrameSource>(
          source,
          FrameSourceOptions{
              .pixels = pixels, .stamps = stamps, .stamps_of_another = true, .bag = bag})) {}

SensorStream::SensorStream(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

// A live camera that stopped does not hold up the upward one: it is waited for again when it has
// returned.
bool SensorStream::Read(Frame& frame) {
  constexpr double kMaxWaitS = 0.2;
  try {
    if (!source_->IsLive()) return source_->Read(frame);
    const bool read = source_->Read(frame, stalled_ ? 0 : kMaxWaitS);
    stalled_ = !read;
    return read;
  } catch (const InputError& error) {
    damage_ = error.what();
    return false;
  }
}

void SensorStream::ReadTo(double stamp_s, const Sink& add) {
  while (!ended_ && (!last_stamp_s_ || *last_stamp_s_ <= stamp_s)) {
    Frame frame;  // a new one each time: the receiver keeps the image
    if (!Read(frame)) {
      ended_ = !damage_.empty() || source_->Ended();
      return;
    }
    last_stamp_s_ = frame.stamp_s;
    add({frame.image, frame.stamp_s, frame.index});
  }
}

std::vector<std::string> SensorStream::Warnings() const {
  std::vector<std::string> warnings = source_->Warnings();
  if (!damage_.empty()) warnings.push_back(damage_ + "; it is not used from there on");
  return warnings;
}

}  // namespace ceilmap::recordings
