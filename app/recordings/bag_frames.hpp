#pragma once

#include <memory>
#include <string>

#include "app/recordings/bag_source.hpp"
#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

/// The images of a topic, sensor_msgs/msg/Image or CompressedImage, as frames. Their times are
/// MessageTimes. An image that cannot be decoded is left out; if it is the first one, it is an
/// error.
class BagFrames final : public FrameReader {
 public:
  BagFrames(std::unique_ptr<BagStream> stream, Pixels pixels, BagStamp stamp);

  bool Next(cv::Mat& image, std::optional<double>& time_s) override;
  [[nodiscard]] Kind GetKind() const override { return Kind::kVideo; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override;
  [[nodiscard]] bool CountsExactly() const override { return true; }
  [[nodiscard]] std::optional<double> FramePeriod() const override;
  [[nodiscard]] std::int64_t LeftOut() const override { return left_out_ + times_.Late(); }
  [[nodiscard]] std::string Part() const override { return stream_->Topic().name; }
  [[nodiscard]] std::vector<std::string> EndRemarks() override;
  void Stop() override { stream_->Stop(); }

 private:
  std::int64_t Decode(cv::Mat& image);

  std::unique_ptr<BagStream> stream_;
  Pixels pixels_;
  MessageTimes times_;
  BagMessage message_;
  std::int64_t frames_ = 0;
  std::int64_t left_out_ = 0;
};

/// The images of a bag. @throws InputError as OpenTopic.
std::unique_ptr<FrameReader> OpenBagFrames(const std::string& bag,
                                           const BagTopic& topic,
                                           Pixels pixels);

}  // namespace ceilmap::recordings
