// Registration of a stream of 640x480 ceiling pictures, one thread, against three measures taken in
// the same run: the Fourier transforms that it cannot do without, the same method put together from
// OpenCV's functions, and feature matching. Every frame's answer is checked.

#include <benchmark/benchmark.h>
#include <fftw3.h>
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <map>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "mapping/registration/coarse.hpp"
#include "mapping/registration/fft.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

using synthetic::AngleErrorDeg;
using synthetic::ShiftError;

const cv::Size kSize(640, 480);
constexpr double kDegree = std::numbers::pi / 180;

/// Processor time of this thread: what a loaded machine does between the time slices of this one is
/// not counted.
double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A reference picture and frames that a robot takes while it drives away from there and back.
struct Sequence {
  cv::Mat reference;
  std::vector<cv::Mat> frames;
  std::vector<ImageMotion> motions;  // reference -> frame
};

const Sequence& Frames() {
  static const Sequence kSequence = [] {
    // Coarse grain, in which features can be found too.
    const synthetic::SyntheticCeiling ceiling({.speckle_grey = 30});
    constexpr double kNoise = 2;
    constexpr int kFrames = 8;
    Sequence s;
    s.reference = ceiling.Render(kSize, {}, kNoise, 100);
    for (int i = 0; i < kFrames; ++i) {
      const double part = static_cast<double>(i) / (kFrames - 1);
      const double shift_px = 5 + 55 * part;
      const double direction = 0.7 + 2.4 * i;
      s.motions.push_back({shift_px * std::cos(direction),
                           shift_px * std::sin(direction),
                           12 * part * kDegree * (i % 2 == 0 ? 1 : -1),
                           1});
      s.frames.push_back(
          ceiling.Render(kSize, s.motions.back(), kNoise, static_cast<std::uint32_t>(i)));
    }
    return s;
  }();
  return kSequence;
}

/// Milliseconds of every single frame, by benchmark.
std::map<std::string, std::vector<double>>& FrameTimes() {
  static std::map<std::string, std::vector<double>> times;
  return times;
}

/// Runs `work(i)` on one frame after the other; it returns the error in the answer, empty when it
/// is right.
template <typename Work>
void RunFrames(benchmark::State& state, const std::string& name, Work work) {
  std::vector<double>& times = FrameTimes()[name];
  std::size_t i = 0;
  while (state.KeepRunning()) {
    const double start = ThreadSeconds();
    const auto answer = work(i);
    const double seconds = ThreadSeconds() - start;
    const std::string error = answer(Frames().motions[i]);
    if (!error.empty()) {
      state.SkipWithError(fmt::format("frame {}: {}", i, error).c_str());
      break;
    }
    state.SetIterationTime(seconds);
    times.push_back(seconds * 1e3);
    i = (i + 1) % Frames().frames.size();
  }
}

/// An answer that can be held against the truth, within a bound.
auto MotionWithin(const ImageMotion& motion, double bound_px, double bound_deg) {
  return [=](const ImageMotion& truth) -> std::string {
    const double shift = ShiftError(motion, truth);
    const double angle = AngleErrorDeg(motion, truth);
    if (shift <= bound_px && angle <= bound_deg) return "";
    return fmt::format("answer is off by {:.3f} px, {:.3f} deg", shift, angle);
  };
}

/// (a) The floor: forward transforms of the frame and of the turned frame, forward and inverse of a
/// 512x256 polar array, one inverse of the frame. Only the transforms are timed; between them their
/// buffers are written, as they would be by the steps around them.
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

/// (b) The coarse stage of one streamed frame.
void Coarse(benchmark::State& state) {
  CoarseStage stage(kSize);
  FrameSpectrum::Data reference;
  FrameSpectrum::Data current;
  stage.Analyze(Frames().reference, reference);
  RunFrames(state, "coarse", [&](std::size_t i) {
    stage.Analyze(Frames().frames[i], current);
    const auto hypotheses = stage.Propose(reference, current, false);
    return MotionWithin(
        hypotheses.empty() ? ImageMotion{1e9, 1e9, 0, 1} : hypotheses.front().motion, 3, 0.5);
  });
}

auto Answer(const Registration& registration, double bound_px, double bound_deg) {
  return MotionWithin(
      registration.ok() ? registration.motion : ImageMotion{1e9, 1e9, 0, 1}, bound_px, bound_deg);
}

constexpr double kFineBoundPx = 0.05;
constexpr double kFineBoundDeg = 0.02;

/// (c) The fine stage of a frame whose spectra are there.
void Fine(benchmark::State& state) {
  Registrar registrar(kSize);
  const FrameSpectrum reference = registrar.Analyze(Frames().reference);
  std::vector<FrameSpectrum> spectra;
  for (const cv::Mat& frame : Frames().frames) spectra.push_back(registrar.Analyze(frame));
  RunFrames(state, "fine", [&](std::size_t i) {
    ImageMotion start = Frames().motions[i];
    start.tx_px += 2 * std::numbers::sqrt2 / 2;
    start.ty_px -= 2 * std::numbers::sqrt2 / 2;
    start.theta_rad += 0.2 * kDegree;
    return Answer(registrar.Refine(reference, spectra[i], start), kFineBoundPx, kFineBoundDeg);
  });
}

void RegisterFrames(benchmark::State& state, const std::string& name, bool estimate_scale) {
  RegistrarParams params;
  params.estimate_scale = estimate_scale;
  Registrar registrar(kSize, params);
  const FrameSpectrum reference = registrar.Analyze(Frames().reference);
  RunFrames(state, name, [&](std::size_t i) {
    const FrameSpectrum current = registrar.Analyze(Frames().frames[i]);
    return Answer(registrar.Register(reference, current), kFineBoundPx, kFineBoundDeg);
  });
}

/// (d) Both stages of one streamed frame.
void Both(benchmark::State& state) {
  RegisterFrames(state, "both", false);
}
/// (e) The same with the scale unknown.
void BothWithScale(benchmark::State& state) {
  RegisterFrames(state, "both, scale", true);
}

/// (f) The coarse method put together from OpenCV: rotation by phase correlation of the log
/// amplitude spectra in polar coordinates, both half turns turned back, translation by phase
/// correlation.
class OpenCvPieces {
 public:
  explicit OpenCvPieces(const cv::Mat& reference) {
    cv::createHanningWindow(window_, kSize, CV_32F);
    reference.convertTo(reference_, CV_32F);
    reference_polar_ = Polar(reference_);
  }

  ImageMotion Register(const cv::Mat& grey) {
    cv::Mat current;
    grey.convertTo(current, CV_32F);
    const cv::Point2d polar_shift = cv::phaseCorrelate(reference_polar_, Polar(current));
    const double theta = polar_shift.y * std::numbers::pi / kAngles;
    double best = -1;
    ImageMotion motion;
    for (const double angle : {theta, theta + std::numbers::pi}) {
      const double cx = 0.5 * (kSize.width - 1);
      const double cy = 0.5 * (kSize.height - 1);
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      const cv::Matx23d back(c, -s, cx - c * cx + s * cy, s, c, cy - s * cx - c * cy);
      cv::Mat turned;
      cv::warpAffine(current, turned, back, kSize, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
      double response = 0;
      const cv::Point2d d = cv::phaseCorrelate(reference_, turned, window_, &response);
      if (response > best) {
        best = response;
        motion = {c * d.x - s * d.y, s * d.x + c * d.y, calib::WrapAngle(angle), 1};
      }
    }
    return motion;
  }

 private:
  static constexpr int kAngles = 360;  // over the half turn
  static constexpr int kRadii = 256;

  [[nodiscard]] cv::Mat Polar(const cv::Mat& picture) const {
    cv::Mat spectrum;
    cv::dft((picture - cv::mean(picture)).mul(window_), spectrum, cv::DFT_COMPLEX_OUTPUT);
    std::array<cv::Mat, 2> parts;
    cv::split(spectrum, parts.data());
    cv::Mat amplitude;
    cv::magnitude(parts[0], parts[1], amplitude);
    cv::log(amplitude + 1, amplitude);
    // Zero frequency to the middle, and bins of equal size on both axes.
    const int w = kSize.width;
    const int h = kSize.height;
    cv::Mat centred(kSize, CV_32FC1);
    for (const int x : {0, w / 2}) {
      for (const int y : {0, h / 2}) {
        amplitude(cv::Rect(x, y, w / 2, h / 2))
            .copyTo(centred(cv::Rect(w / 2 - x, h / 2 - y, w / 2, h / 2)));
      }
    }
    cv::Mat square;
    cv::resize(centred, square, {h, h});
    cv::Mat polar;
    cv::warpPolar(square,
                  polar,
                  {kRadii, 2 * kAngles},
                  cv::Point2f(0.5F * static_cast<float>(h), 0.5F * static_cast<float>(h)),
                  0.5 * h,
                  cv::INTER_LINEAR | cv::WARP_FILL_OUTLIERS);
    // A half turn, between 0.03 and 0.35 cycles per pixel.
    return polar(cv::Rect(15, 0, 163, kAngles)).clone();
  }

  cv::Mat window_;
  cv::Mat reference_;
  cv::Mat reference_polar_;
};

void OpenCv(benchmark::State& state) {
  OpenCvPieces pieces(Frames().reference);
  RunFrames(state, "OpenCV pieces", [&](std::size_t i) {
    return MotionWithin(pieces.Register(Frames().frames[i]), 2, 0.5);
  });
}

/// (g) Features.
void Orb(benchmark::State& state) {
  const auto orb = cv::ORB::create();
  const cv::BFMatcher matcher(cv::NORM_HAMMING, true);
  std::vector<cv::KeyPoint> reference_keys;
  cv::Mat reference_descriptors;
  orb->detectAndCompute(Frames().reference, cv::noArray(), reference_keys, reference_descriptors);
  RunFrames(state, "ORB", [&](std::size_t i) {
    std::vector<cv::KeyPoint> keys;
    cv::Mat descriptors;
    orb->detectAndCompute(Frames().frames[i], cv::noArray(), keys, descriptors);
    std::vector<cv::DMatch> matches;
    matcher.match(reference_descriptors, descriptors, matches);
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    for (const cv::DMatch& match : matches) {
      from.push_back(reference_keys[static_cast<std::size_t>(match.queryIdx)].pt);
      to.push_back(keys[static_cast<std::size_t>(match.trainIdx)].pt);
    }
    const cv::Mat m = cv::estimateAffinePartial2D(from, to);
    ImageMotion motion{1e9, 1e9, 0, 1};
    if (!m.empty()) {
      const double cx = 0.5 * (kSize.width - 1);
      const double cy = 0.5 * (kSize.height - 1);
      const double a = m.at<double>(0, 0);
      const double b = m.at<double>(1, 0);
      motion = {m.at<double>(0, 2) + a * cx - b * cy - cx,
                m.at<double>(1, 2) + b * cx + a * cy - cy,
                std::atan2(b, a),
                std::hypot(a, b)};
    }
    return MotionWithin(motion, 2, 0.5);
  });
}

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return std::nan("");
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

void PrintTable() {
  const auto median = [](const char* name) { return Quantile(FrameTimes()[name], 0.5); };
  fmt::print("\n640x480, one thread, processor time in ms per frame over all repetitions\n");
  fmt::print("{:<16}{:>9}{:>9}\n", "", "median", "p95");
  for (const char* name :
       {"floor", "coarse", "fine", "both", "both, scale", "OpenCV pieces", "ORB"}) {
    fmt::print("{:<16}{:>9.2f}{:>9.2f}\n", name, median(name), Quantile(FrameTimes()[name], 0.95));
  }
  fmt::print("\nratios of the medians\n");
  for (const auto& [over, under] : {std::pair{"coarse", "floor"},
                                    {"both", "floor"},
                                    {"both, scale", "floor"},
                                    {"OpenCV pieces", "both"},
                                    {"ORB", "both"}}) {
    fmt::print(
        "{:<30}{:>8.2f}\n", fmt::format("{} / {}", over, under), median(over) / median(under));
  }
}

int Main(int argc, char** argv) {
  cv::setNumThreads(1);
  // Interleaved repetitions: what else the machine does meanwhile hits all of them alike.
  std::vector<std::string> texts{argv[0],
                                 "--benchmark_enable_random_interleaving=true",
                                 "--benchmark_repetitions=9",
                                 "--benchmark_min_time=0.2",
                                 "--benchmark_report_aggregates_only=true"};
  texts.insert(texts.end(), argv + 1, argv + argc);
  std::vector<char*> arguments;
  arguments.reserve(texts.size());
  for (std::string& text : texts) arguments.push_back(text.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  const std::pair<const char*, void (*)(benchmark::State&)> all[] = {{"floor", TransformsAlone},
                                                                     {"coarse", Coarse},
                                                                     {"fine", Fine},
                                                                     {"both", Both},
                                                                     {"both_scale", BothWithScale},
                                                                     {"opencv_pieces", OpenCv},
                                                                     {"orb", Orb}};
  for (const auto& [name, function] : all) {
    benchmark::RegisterBenchmark(name, function)->Unit(benchmark::kMillisecond)->UseManualTime();
  }
  benchmark::RunSpecifiedBenchmarks();
  PrintTable();
  benchmark::Shutdown();
  return 0;
}

}  // namespace
}  // namespace ceilmap::registration

int main(int argc, char** argv) {
  return ceilmap::registration::Main(argc, argv);
}
