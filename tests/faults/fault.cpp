#include "tests/faults/fault.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tests/faults/h264.hpp"
#include "tests/faults/recording_faults.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

// Flips bytes in this share of the pictures' NAL units, behind their headers: what a bad cable,
// card or radio does. The first picture stays whole where `later` says so.
void FlipBytes(const fs::path& file, double share, bool later, Random& random) {
  constexpr int kFlipsEach = 4;
  std::string bytes = ReadBytes(file);
  std::vector<NalUnit> pictures =
      file.extension() == ".mp4" ? NalUnitsOfMp4(bytes) : NalUnitsOfAnnexB(bytes);
  std::erase_if(pictures, [](const NalUnit& unit) { return unit.type != 1 && unit.type != 5; });
  std::uniform_real_distribution<double> chance(0, 1);
  std::uniform_int_distribution<int> flip(1, 255);
  for (std::size_t i = later ? 1 : 0; i < pictures.size(); ++i) {
    if (chance(random) >= share) continue;
    std::uniform_int_distribution<std::size_t> place(1, pictures[i].size - 1);
    for (int k = 0; k < kFlipsEach; ++k) {
      char& byte = bytes[pictures[i].begin + place(random)];
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

// From the middle on the pictures of a folder are of another size.
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

Fault Pictures(const std::string& name,
               const std::function<Recording(const Recording&, Random&)>& recording) {
  return {name, recording};
}

Fault Corrupted(const std::string& name, Storage storage, double share, bool later) {
  Fault fault{name, {}, storage};
  fault.file = [=](const fs::path& file, Random& random) { FlipBytes(file, share, later, random); };
  return fault;
}

std::vector<Fault> MakeFaults() {
  std::vector<Fault> faults = {{"none"}};
  for (const int percent : {1, 10, 50}) {
    faults.push_back(Pictures("dropped frames, " + std::to_string(percent) + " %",
                              [=](const Recording& good, Random& random) {
                                return DropFrames(good, 0.01 * percent, random);
                              }));
  }
  faults.push_back(Pictures("salt noise, 5 %", [](const Recording& good, Random& random) {
    return SaltNoise(good, 0.05, random);
  }));
  faults.push_back(Corrupted("H.264, bytes flipped in 5 % of packets", Storage::kMp4, 0.05, true));
  return faults;
}

}  // namespace

const std::vector<Fault>& AllFaults() {
  static const std::vector<Fault> faults = MakeFaults();
  return faults;
}

const Fault& FaultNamed(const std::string& name) {
  const std::vector<Fault>& all = AllFaults();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Fault& fault) { return fault.name == name; });
  if (found == all.end()) throw std::out_of_range("there is no fault named '" + name + "'");
  return *found;
}

}  // namespace ceilmap::faults
