#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

struct StreamReaderParams {
  /// Longest time without frames before the run ends, in seconds: after a failure (connection lost,
  /// no data, camera unplugged), ...
  double max_outage_s = 30;
  /// ... and after the sender closed the stream in order, which is how most streams end.
  double max_pause_s = 3;
  /// A connection that was shorter than this is part of the outage before it: some senders repeat
  /// their last frame for each client, for ever.
  double min_connection_s = 2;
  /// Before the second attempt, and before the first one after a short connection; doubles with
  /// each attempt, ...
  double first_delay_s = 0.5;
  double max_delay_s = 5;  ///< ... up to this

  std::function<double()> now_s;            ///< a steady clock, seconds
  std::function<void(double)> sleep;        ///< for that many seconds, at most 0.1
  std::function<void(std::string)> notice;  ///< receives a line when an outage begins

  /// This machine's clock, and notes on the terminal.
  StreamReaderParams();
};

/// A camera or a stream that is opened again when it fails or ends.
class StreamReader final : public FrameReader {
 public:
  using Opener = std::function<std::unique_ptr<FrameReader>()>;

  /// @param first  the open source. @param open  opens it again; throws InputError while it cannot
  /// be opened.
  StreamReader(std::string name,
               std::unique_ptr<FrameReader> first,
               Opener open,
               StreamReaderParams params = {});

  /// @return false when the source did not return in time, after an interruption and after Stop().
  bool Next(cv::Mat& image, std::optional<double>& time_s) override;
  [[nodiscard]] Kind GetKind() const override { return Kind::kLive; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override { return {}; }
  [[nodiscard]] std::optional<double> FramePeriod() const override { return period_s_; }
  [[nodiscard]] registration::Encoding GetEncoding() const override {
    return reader_ ? reader_->GetEncoding() : registration::Encoding();
  }
  [[nodiscard]] bool CanStall() const override { return true; }
  [[nodiscard]] std::int64_t LeftOut() const override;
  [[nodiscard]] std::vector<std::string> Remarks() const override { return remarks_; }
  [[nodiscard]] bool OnSteadyClock() const override { return on_steady_clock_; }
  [[nodiscard]] Outages GetOutages() const override { return outages_; }
  void Stop() override { stop_ = true; }

 private:
  bool Reopen(cv::Mat& image, std::optional<double>& time_s);
  bool TryAgain(cv::Mat& image, std::optional<double>& time_s);
  bool Wait(double seconds) const;
  void Release();

  std::string name_;
  std::unique_ptr<FrameReader> reader_;  // null while it cannot be opened
  Opener open_;
  StreamReaderParams params_;
  std::optional<double> period_s_;
  std::vector<std::string> remarks_;
  bool on_steady_clock_;
  std::int64_t left_out_ = 0;  // by earlier readers
  double opened_s_;
  double outage_began_s_ = 0;
  double last_frame_s_;
  Outages outages_;
  std::atomic<bool> stop_ = false;
};

}  // namespace ceilmap::recordings
