// What the papers on visual compasses plot and compare. From recordings with a camera under a
// mirror (samples/compass-experiments.sh renders them):
//   metrics FOLDER...              other metrics and colour spaces (Labrosse 2006, section 5)
//   distances FOLDER FRAME COUNT   distance over shift to the frames after one (Fig. 6, 8, 11, 12)
//   positions FOLDER TARGET        distance to an image over the place (Labrosse 2004, Fig. 2)
// From recordings with a forward camera (samples/colour-experiments.sh):
//   transitions MODEL FOLDER PNG   colour classes and transitions of a scan line (ViCTORiA, Fig. 3)
//   histograms MODEL FOLDER...     values of Y, U and V of several cameras (Fig. 6)
// Each prints CSV.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/panorama_source.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/fields_of_view.hpp"
#include "localization/compass/labrosse/shift_minimum.hpp"
#include "tests/bench/colour_figures.hpp"
#include "tests/bench/panorama_metrics.hpp"

namespace ceilmap::bench {
namespace {

namespace fs = std::filesystem;
constexpr int kColumns = 360;
constexpr double kMaxDtS = 0.02;  // between an image and its true pose

struct Recording {
  std::vector<cv::Mat> panoramas;
  std::vector<double> stamps_s;
  std::vector<StampedPose> truth;
};

Recording Read(const fs::path& folder, int rows) {
  recordings::PanoramaOptions options;
  options.omni = (folder / "omni.mp4").string();
  options.stamps = folder / "frames.csv";
  options.ring = "239.5,239.5,70,220";
  options.columns = kColumns;
  options.rows = rows;
  options.interpolation = "bilinear";
  recordings::PanoramaSource source(options);
  Recording recording;
  recording.truth = files::ReadTum(folder / "truth.tum");
  while (source.Read()) {
    recording.panoramas.push_back(source.Panorama().clone());
    recording.stamps_s.push_back(source.Raw().stamp_s);
  }
  return recording;
}

std::vector<int> FieldColumns() {
  const std::vector<float> weights = compass::FieldsOfView{}.ColumnWeights(kColumns);
  std::vector<int> columns;
  for (int u = 0; u < kColumns; ++u) {
    if (weights[static_cast<std::size_t>(u)] > 0) columns.push_back(u);
  }
  return columns;
}

/// Heading by the least distance over 40 degrees to either side, between successive images,
/// parabola between the columns.
std::vector<evaluation::StampedHeading> HeadingsBy(const Recording& recording,
                                                   const std::string& space,
                                                   Metric metric,
                                                   int step) {
  constexpr int kReach = 40;
  const std::vector<int> columns = FieldColumns();
  std::vector<evaluation::StampedHeading> headings{{recording.stamps_s[0], 0}};
  cv::Mat before = InSpace(recording.panoramas[0], space);
  for (std::size_t i = static_cast<std::size_t>(step); i < recording.panoramas.size();
       i += static_cast<std::size_t>(step)) {
    cv::Mat now = InSpace(recording.panoramas[i], space);
    std::vector<double> distances;
    for (int shift = -kReach - 1; shift <= kReach + 1; ++shift) {
      distances.push_back(Distance(before, now, columns, shift, metric));
    }
    std::size_t least = 1;
    for (std::size_t k = 1; k + 1 < distances.size(); ++k) {
      if (distances[k] < distances[least]) least = k;
    }
    const double part =
        labrosse::ParabolicMinimum({distances[least - 1], distances[least], distances[least + 1]})
            .shift;
    const double shift = static_cast<double>(least) - kReach - 1 + part;
    headings.push_back(
        {recording.stamps_s[i],
         WrapAngle(headings.back().heading_rad + shift / kColumns * 2 * std::numbers::pi)});
    before = std::move(now);
  }
  return headings;
}

void CompareMetrics(const std::vector<std::string>& folders) {
  constexpr int kRows = 45;
  constexpr int kStep = 4;  // Fx 3
  fmt::print("recording,space,metric,max_deg,rms_deg,mean_deg,std_deg,slope_deg_s\n");
  for (const std::string& folder : folders) {
    const Recording recording = Read(folder, kRows);
    for (const std::string space : {"RGB", "Lab", "grey"}) {
      for (const auto& [metric, name] : Metrics()) {
        // Mutual information is that of grey values.
        if (metric == Metric::kMutualInformation && space != "grey") continue;
        const auto errors = evaluation::CompareHeadings(
            HeadingsBy(recording, space, metric, kStep), recording.truth, kMaxDtS);
        if (!errors) throw InputError(folder + ": no true poses at the times of the images");
        fmt::print("{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.4f}\n",
                   fs::path(folder).filename().string(),
                   space,
                   name,
                   errors->error_deg.max,
                   errors->error_deg.rmse,
                   errors->signed_mean_deg,
                   errors->std_deg,
                   errors->drift_deg_per_s.value_or(0));
        std::fflush(stdout);
      }
    }
  }
}

void PrintDistances(const fs::path& folder, int frame, int count) {
  const Recording recording = Read(folder, 150);
  const auto frames = static_cast<int>(recording.panoramas.size());
  if (frame < 0 || count < 0 || frame + count >= frames) {
    throw InputError(fmt::format("{} has the frames 0 to {}", folder.string(), frames - 1));
  }
  std::vector<int> all(kColumns);
  for (int u = 0; u < kColumns; ++u) all[static_cast<std::size_t>(u)] = u;
  const auto at = [&](int i) {
    return InSpace(recording.panoramas[static_cast<std::size_t>(i)], "RGB");
  };
  const cv::Mat reference = at(frame);
  const auto distance = [&](const cv::Mat& current, int shift) {
    return Distance(reference, current, all, shift, Metric::kL2);
  };
  const double own = distance(reference, kColumns / 2);
  fmt::print("frame,shift_deg,distance,kind\n");
  for (int i = frame; i <= frame + count; ++i) {
    const cv::Mat current = at(i);
    int least = 0;
    for (int shift = -kColumns / 2; shift < kColumns / 2; ++shift) {
      const double value = distance(current, shift);
      if (value < distance(current, least)) least = shift;
      fmt::print("{},{},{:.6g},curve\n", i, shift, value);
    }
    const labrosse::ShiftNeighbours around{
        distance(current, least - 1), distance(current, least), distance(current, least + 1)};
    const double amplitude = (distance(current, least + kColumns / 2) - around.least) / own;
    const auto parabola = labrosse::ParabolicMinimum(around);
    const auto mixture = labrosse::BlendedMinimum(around, labrosse::LinearPart(amplitude));
    fmt::print("{},{:.4f},{:.6g},parabola\n", i, least + parabola.shift, parabola.distance);
    fmt::print("{},{:.4f},{:.6g},mixture\n", i, least + mixture.shift, mixture.distance);
  }
}

/// Distances after both images are turned to the same heading by the truth, over all columns.
void PrintPositions(const fs::path& folder, int target) {
  const Recording recording = Read(folder, 45);
  if (target < 0 || target >= static_cast<int>(recording.panoramas.size()) ||
      recording.truth.size() != recording.panoramas.size()) {
    throw InputError(folder.string() +
                     ": needs a true pose for each image, and the target among them");
  }
  std::vector<int> all(kColumns);
  for (int u = 0; u < kColumns; ++u) all[static_cast<std::size_t>(u)] = u;
  const auto yaw = [&](std::size_t i) { return YawOf(recording.truth[i]); };
  const auto to = static_cast<std::size_t>(target);
  const cv::Mat reference = InSpace(recording.panoramas[to], "RGB");
  fmt::print("x_m,y_m,distance\n");
  for (std::size_t i = 0; i < recording.panoramas.size(); ++i) {
    const double turn = WrapAngle(yaw(i) - yaw(to));
    const int shift = static_cast<int>(std::lround(turn / (2 * std::numbers::pi) * kColumns));
    const cv::Mat current = InSpace(recording.panoramas[i], "RGB");
    fmt::print("{:.4f},{:.4f},{:.6g}\n",
               recording.truth[i].position.x(),
               recording.truth[i].position.y(),
               Distance(reference, current, all, shift, Metric::kL2));
  }
}

int Run(const std::vector<std::string>& args) {
  if (args.size() >= 2 && args[0] == "metrics") {
    CompareMetrics({args.begin() + 1, args.end()});
  } else if (args.size() == 4 && args[0] == "distances") {
    PrintDistances(args[1], std::stoi(args[2]), std::stoi(args[3]));
  } else if (args.size() == 3 && args[0] == "positions") {
    PrintPositions(args[1], std::stoi(args[2]));
  } else if (args.size() == 4 && args[0] == "transitions") {
    PrintTransitions(args[1], args[2], args[3]);
  } else if (args.size() >= 3 && args[0] == "histograms") {
    PrintHistograms(args[1], {args.begin() + 2, args.end()});
  } else {
    fmt::print(stderr,
               "usage: ceilmap_papers_bench metrics FOLDER... | distances FOLDER FRAME COUNT | "
               "positions FOLDER TARGET | transitions MODEL FOLDER PNG | histograms MODEL "
               "FOLDER...\n");
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  try {
    return ceilmap::bench::Run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "ceilmap_papers_bench: {}\n", error.what());
    return 2;
  }
}
