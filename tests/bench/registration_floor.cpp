#include <fftw3.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/registration/fft.hpp"
#include "tests/bench/registration_frames.hpp"
#include "tests/bench/registration_yardsticks.hpp"

namespace ceilmap::bench {

using registration::ComplexArray;
using registration::RealArray;

namespace {

/// Forward transforms of the frame and of the turned frame, forward and inverse of a 512x256 polar
/// array, one inverse of the frame. Only the transforms are timed; between them their buffers are
/// written, as they would be by the steps around them.
class Floor {
 public:
  Floor()
      : frame_(Area(kSize)),
        polar_(Area(kPolar)),
        frame_bins_(Bins(kSize)),
        polar_bins_(Bins(kPolar)),
        frame_forward_(Forward(kSize, frame_, frame_bins_)),
        frame_inverse_(Inverse(kSize, frame_, frame_bins_)),
        polar_forward_(Forward(kPolar, polar_, polar_bins_)),
        polar_inverse_(Inverse(kPolar, polar_, polar_bins_)) {}
  Floor(const Floor&) = delete;
  Floor& operator=(const Floor&) = delete;
  ~Floor() {
    for (fftwf_plan plan : {frame_forward_, frame_inverse_, polar_forward_, polar_inverse_}) {
      fftwf_destroy_plan(plan);
    }
  }

  /// Seconds that the transforms of one frame take.
  double Run(const cv::Mat& frame) {
    double seconds = 0;
    const auto run = [&seconds](fftwf_plan plan) {
      const double start = ThreadSeconds();
      fftwf_execute(plan);
      seconds += ThreadSeconds() - start;
    };
    Fill(frame, kSize, frame_);
    run(frame_forward_);
    Fill(frame, kPolar, polar_);
    run(polar_forward_);
    Damp(polar_bins_);
    run(polar_inverse_);
    Fill(frame, kSize, frame_);
    run(frame_forward_);
    Damp(frame_bins_);
    run(frame_inverse_);
    benchmark::DoNotOptimize(frame_.data());
    benchmark::DoNotOptimize(polar_.data());
    return seconds;
  }

 private:
  static inline const cv::Size kPolar{256, 512};

  static std::size_t Area(cv::Size size) { return static_cast<std::size_t>(size.area()); }
  static std::size_t Bins(cv::Size size) {
    return static_cast<std::size_t>(size.height) * (static_cast<std::size_t>(size.width) / 2 + 1);
  }
  static fftwf_complex* AsFftw(ComplexArray& bins) {
    return reinterpret_cast<fftwf_complex*>(bins.data());
  }
  static fftwf_plan Forward(cv::Size size, RealArray& real, ComplexArray& bins) {
    return fftwf_plan_dft_r2c_2d(size.height, size.width, real.data(), AsFftw(bins), FFTW_MEASURE);
  }
  static fftwf_plan Inverse(cv::Size size, RealArray& real, ComplexArray& bins) {
    return fftwf_plan_dft_c2r_2d(size.height, size.width, AsFftw(bins), real.data(), FFTW_MEASURE);
  }
  static void Fill(const cv::Mat& grey, cv::Size size, RealArray& real) {
    cv::Mat values(size, CV_32FC1, real.data());
    grey(cv::Rect(0, 0, size.width, std::min(size.height, grey.rows)))
        .convertTo(values.rowRange(0, std::min(size.height, grey.rows)), CV_32F);
  }
  static void Damp(ComplexArray& bins) {
    for (std::size_t i = 0; i < bins.size(); ++i) bins[i] *= 1e-3F;
  }

  RealArray frame_;
  RealArray polar_;
  ComplexArray frame_bins_;
  ComplexArray polar_bins_;
  fftwf_plan frame_forward_;
  fftwf_plan frame_inverse_;
  fftwf_plan polar_forward_;
  fftwf_plan polar_inverse_;
};

}  // namespace

void TransformsAlone(benchmark::State& state) {
  static Floor floor;
  std::vector<double>& times = FrameTimes()["floor"];
  std::size_t i = 0;
  while (state.KeepRunning()) {
    const double seconds = floor.Run(Frames().frames[i]);
    state.SetIterationTime(seconds);
    times.push_back(seconds * 1e3);
    i = (i + 1) % Frames().frames.size();
  }
}

}  // namespace ceilmap::bench
