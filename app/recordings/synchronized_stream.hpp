#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"

namespace ceilmap::recordings {

/// The images of a second camera that go with those of the first, matched by time. It may have
/// other frames than the first, begin later and end sooner: what it lacks is left out and told.
class SynchronizedStream {
 public:
  struct Report {
    std::int64_t matched = 0;
    std::int64_t missing = 0;     ///< frames of the first camera without one of this
    double largest_offset_s = 0;  ///< between matched frames
    FrameSourceReport reading;
  };

  /// @param stamps  of its frames, or of the first camera's where those are as many; empty: the
  /// recording's own time. @throws InputError when the source cannot be used.
  SynchronizedStream(const std::string& source,
                     const std::filesystem::path& stamps,
                     std::string name = "forward");
  /// The same with a source that is open already.
  /// @param name  what it is called in warnings.
  explicit SynchronizedStream(std::unique_ptr<FrameSource> source, std::string name = "forward");

  [[nodiscard]] cv::Size Size() const { return source_->Size(); }
  [[nodiscard]] const std::string& Name() const { return source_->Name(); }

  /// The image nearest in time, not farther than 50 ms; empty where there is none. Times must not
  /// go back. Valid until the next call. A recording that turns out to be damaged ends there.
  cv::Mat At(double stamp_s);
  /// The same with its number and time; null where there is none.
  const Frame* Nearest(double stamp_s);

  [[nodiscard]] Report GetReport() const;
  /// What was not as it should be, a line each; complete at the end of the first recording.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  void Advance();

  std::unique_ptr<FrameSource> source_;
  std::string name_;
  std::optional<Frame> before_;  // the last one that is not later than what was asked for
  std::optional<Frame> after_;   // the first one that is later
  bool ended_ = false;
  std::string damage_;
  Report report_;
};

}  // namespace ceilmap::recordings
