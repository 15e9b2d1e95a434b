#include "tests/faults/fault.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tests/faults/recording_faults.hpp"
#include "tests/support/h264.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

// Flips bytes in this share of the images' NAL units but the first, behind their headers: what a
// bad cable, card or radio does.
void FlipBytes(const fs::path& file, double share, Random& random) {
  constexpr int kFlipsEach = 4;
  std::string bytes = ReadBytes(file);
  std::vector<support::NalUnit> images =
      file.extension() == ".mp4" ? support::NalUnitsOfMp4(bytes) : support::NalUnitsOfAnnexB(bytes);
  std::erase_if(images,
                [](const support::NalUnit& unit) { return unit.type != 1 && unit.type != 5; });
  std::uniform_real_distribution<double> chance(0, 1);
  std::uniform_int_distribution<int> flip(1, 255);
  for (std::size_t i = 1; i < images.size(); ++i) {
    if (chance(random) >= share) continue;
    std::uniform_int_distribution<std::size_t> place(1, images[i].size - 1);
    for (int k = 0; k < kFlipsEach; ++k) {
      char& byte = bytes[images[i].begin + place(random)];
      byte =
          static_cast<char>(static_cast<unsigned char>(byte) ^ static_cast<unsigned>(flip(random)));
    }
  }
  WriteBytes(file, bytes);
}

void Truncate(const fs::path& file, double part) {
  fs::resize_file(file,
                  static_cast<std::uintmax_t>(part * static_cast<double>(fs::file_size(file))));
}

// From the middle on the images of a folder are of another size.
void ChangeSize(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (std::size_t i = files.size() / 2; i < files.size(); ++i) {
    cv::Mat smaller;
    cv::resize(cv::imread(files[i].string(), cv::IMREAD_GRAYSCALE), smaller, {}, 0.5, 0.5);
    cv::imwrite(files[i].string(), smaller);
  }
}

Fault Images(const std::string& name,
             const std::function<Recording(const Recording&, Random&)>& recording) {
  return {name, recording};
}

Fault Corrupted(const std::string& name, Storage storage, double share) {
  Fault fault{name, {}, storage};
  fault.file = [=](const fs::path& file, Random& random) { FlipBytes(file, share, random); };
  return fault;
}

void AddOrderFaults(std::vector<Fault>& faults) {
  for (const int percent : {1, 10, 50}) {
    faults.push_back(Images("dropped frames, " + std::to_string(percent) + " %",
                            [=](const Recording& good, Random& random) {
                              return DropFrames(good, 0.01 * percent, random);
                            }));
  }
  faults.push_back(Images("duplicated frames, 10 %", [](const Recording& good, Random& random) {
    return DuplicateFrames(good, 0.1, random);
  }));
  faults.push_back(Images("swapped frames, 5 %", [](const Recording& good, Random& random) {
    return SwapFrames(good, 0.05, random);
  }));
}

void AddImageFaults(std::vector<Fault>& faults) {
  const auto add = [&faults](const char* name, auto change) {
    faults.push_back(Images(name, change));
  };
  add("flicker, every other image at 0.4",
      [](const Recording& good, Random&) { return Flicker(good, 0.4); });
  add("exposure jumps, 10 of 0.35 to 2.5",
      [](const Recording& good, Random& random) { return ExposureJumps(good, 10, random); });
  add("motion blur of 9 px in 20 %",
      [](const Recording& good, Random& random) { return MotionBlur(good, 0.2, 9, random); });
  add("motion blur of 25 px in 20 %",
      [](const Recording& good, Random& random) { return MotionBlur(good, 0.2, 25, random); });
  add("salt noise, 0.2 %",
      [](const Recording& good, Random& random) { return SaltNoise(good, 0.002, random); });
  add("salt noise, 5 %",
      [](const Recording& good, Random& random) { return SaltNoise(good, 0.05, random); });
  add("dead rows, 4 of 240",
      [](const Recording& good, Random& random) { return DeadRows(good, 4, random); });
  add("half the lens covered, from the middle on",
      [](const Recording& good, Random&) { return CoveredHalf(good); });
  add("dark for a third of the way", [](const Recording& good, Random&) { return Dark(good); });
}

void AddFileFaults(std::vector<Fault>& faults) {
  faults.push_back({"x265, CRF 35", {}, Storage::kCoarse});
  faults.push_back(Corrupted("H.264 (MP4), bytes flipped in 1 % of packets", Storage::kMp4, 0.01));
  faults.push_back(Corrupted("H.264 (MP4), bytes flipped in 5 % of packets", Storage::kMp4, 0.05));
  faults.push_back(
      Corrupted("H.264 (stream), bytes flipped in 1 % of packets", Storage::kAnnexB, 0.01));
  Fault cut{"MP4 cut off at two thirds", {}, Storage::kMp4};
  cut.file = [](const fs::path& file, Random&) { Truncate(file, 2.0 / 3); };
  faults.push_back(cut);
  Fault size{"frame size that changes midway"};
  size.file = [](const fs::path& folder, Random&) { ChangeSize(folder); };
  faults.push_back(size);
  Fault back{"stamps that jump back"};
  back.recording = [](const Recording& good, Random&) {
    Recording faulty = good;
    for (std::size_t i = good.size() / 2; i < good.size(); ++i) faulty[i].stamp_s -= 3;
    return faulty;
  };
  faults.push_back(back);
}

std::vector<Fault> MakeFaults() {
  std::vector<Fault> faults = {{"none"}};
  AddOrderFaults(faults);
  AddImageFaults(faults);
  AddFileFaults(faults);
  return faults;
}

}  // namespace

const std::vector<Fault>& AllFaults() {
  static const std::vector<Fault> kFaults = MakeFaults();
  return kFaults;
}

const Fault& FaultNamed(const std::string& name) {
  const std::vector<Fault>& all = AllFaults();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Fault& fault) { return fault.name == name; });
  if (found == all.end()) throw std::out_of_range("there is no fault named '" + name + "'");
  return *found;
}

}  // namespace ceilmap::faults
