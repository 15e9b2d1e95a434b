#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "localization/robot/image.hpp"

namespace ceilmap::recordings {

/// The recording of a camera beside the upward one. A recording that turns out to be damaged ends
/// there; the rest of the run goes on without it.
class SensorStream {
 public:
  using Sink = std::function<void(const robot::Image& image)>;

  /// @param stamps  of its frames, or of the upward camera's where those are as many; empty: the
  /// recording's own time. @param bag  which images, where the source is a bag. @throws InputError
  /// when the source cannot be used.
  SensorStream(const std::string& source,
               const std::filesystem::path& stamps,
               Pixels pixels = Pixels::kGrey,
               const BagTopic& bag = {});
  /// The same with a source that is open already.
  explicit SensorStream(std::unique_ptr<FrameSource> source);

  [[nodiscard]] cv::Size Size() const { return source_->Size(); }
  [[nodiscard]] const std::string& Name() const { return source_->Name(); }

  /// Reads as far as the first image that is later than `stamp_s` and passes each image on. Waits
  /// for images of a live source, up to 0.2 s, and no more until it delivers again. Stamps must not
  /// decrease.
  void ReadTo(double stamp_s, const Sink& add);

  [[nodiscard]] FrameSourceReport Reading() const { return source_->Report(); }
  /// Problems of the recording, one line each; complete at the end of the upward recording.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  bool Read(Frame& frame);

  std::unique_ptr<FrameSource> source_;
  std::optional<double> last_stamp_s_;
  bool ended_ = false;
  bool stalled_ = false;  // a live source without images in time
  std::string damage_;
};

}  // namespace ceilmap::recordings
