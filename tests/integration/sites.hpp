#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {

/// One room driven through three times, and another room. The drives share parts of their path:
/// frames [0, 50), [32, 80) and [12, 62) of one straight line of 0.063 m a frame, recorded at other
/// times. The third robot has another camera, at another height.
class Sites {
 public:
  static constexpr int kFirst = 50;
  static constexpr int kSecondBegins = 32;
  static constexpr int kSecond = 48;
  static constexpr int kWideBegins = 12;
  static constexpr int kWide = 50;

  Sites() {
    std::filesystem::copy(
        RecordedOnce().Path(), recordings.in.Path(), std::filesystem::copy_options::recursive);
  }

  [[nodiscard]] std::vector<std::string> MapArguments(const std::string& name,
                                                      const std::string& map) const {
    return {"map",
            name == "wide" ? "--rig=@wide.yaml" : "--rig=@rig.yaml",
            "--up=@" + name,
            "--stamps=@" + name + ".csv",
            "-o",
            map,
            "--trajectory=" + name + ".tum",
            "--force"};
  }
  [[nodiscard]] support::ProcessResult Map(const std::string& name, const std::string& map) const {
    return recordings.Run(MapArguments(name, map));
  }
  [[nodiscard]] nlohmann::json Info(const std::string& map) const {
    const support::ProcessResult result = recordings.Run({"info", map, "--json"});
    EXPECT_EQ(result.exit_code, 0) << map << ": " << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  }

  Recordings recordings;

 private:
  static cv::Mat Ceiling(int room) {
    const cv::Mat ceiling = support::SyntheticCeiling({820, 820});
    return room == 0 ? ceiling.rowRange(0, 410) : ceiling.rowRange(410, 820);
  }
  static void Write(const support::TestFolder& folder,
                    const std::string& name,
                    const std::vector<cv::Mat>& images,
                    double first_s) {
    support::WriteImages(folder / name, images);
    folder.Write(name + ".csv", support::StampsCsv(static_cast<int>(images.size()), first_s, 0.1));
  }
  /// Images of 320x240 px of a camera that shows 12.5 mm per pixel, with the same centres.
  static std::vector<cv::Mat> WideImages(const cv::Mat& ceiling) {
    const cv::Size shown(400, 300);
    std::vector<cv::Mat> images;
    for (int i = kWideBegins; i < kWideBegins + kWide; ++i) {
      const cv::Point corner =
          cv::Point(10, 10) + i * kStep -
          cv::Point(shown.width - kImageSize.width, shown.height - kImageSize.height) / 2;
      cv::Mat image;
      cv::resize(ceiling(cv::Rect(corner, shown)), image, kImageSize, 0, 0, cv::INTER_AREA);
      images.push_back(image);
    }
    return images;
  }
  /// At 0.9 m, 1.5 m below the ceiling: 12.5 mm per pixel.
  static std::string WideRig() {
    std::string rig = kRig;
    for (const auto& [from, to] : {std::pair{"[200, 0, 159.5, 0, 200,", "[120, 0, 159.5, 0, 120,"},
                                   std::pair{"[0, 0, 0.4]", "[0, 0, 0.9]"}}) {
      rig.replace(rig.find(from), std::string(from).size(), to);
    }
    return rig;
  }
  /// Encoded once; each test has a copy.
  static const support::TestFolder& RecordedOnce() {
    static const support::TestFolder folder;
    static const bool written = [] {
      constexpr int kAll = kSecondBegins + kSecond;
      const std::vector<cv::Mat> all = support::CropAlong(Ceiling(0), kImageSize, kStep, kAll);
      Write(folder, "first", {all.begin(), all.begin() + kFirst}, 100);
      Write(folder, "second", {all.begin() + kSecondBegins, all.end()}, 1000);
      Write(folder, "wide", WideImages(Ceiling(0)), 3000);
      folder.Write("wide.yaml", WideRig());
      Write(folder, "elsewhere", support::CropAlong(Ceiling(1), kImageSize, kStep, kFirst), 2000);
      return true;
    }();
    static_cast<void>(written);
    return folder;
  }
};

}  // namespace ceilmap::integration
