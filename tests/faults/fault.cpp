#include "tests/faults/fault.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "tests/faults/motion_faults.hpp"
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

std::vector<Fault> RecordingFaults() {
  std::vector<Fault> faults = {{"none"}};
  AddOrderFaults(faults);
  AddImageFaults(faults);
  AddFileFaults(faults);
  return faults;
}

// Those of the recordings that a world of another kind repeats.
std::vector<Fault> SomeRecordingFaults() {
  const std::vector<Fault> all = RecordingFaults();
  std::vector<Fault> faults;
  for (const char* const name : {"none",
                                 "dropped frames, 50 %",
                                 "exposure jumps, 10 of 0.35 to 2.5",
                                 "motion blur of 25 px in 20 %",
                                 "salt noise, 5 %",
                                 "half the lens covered, from the middle on",
                                 "dark for a third of the way",
                                 "x265, CRF 35",
                                 "H.264 (MP4), bytes flipped in 1 % of packets"}) {
    faults.push_back(*std::find_if(
        all.begin(), all.end(), [&](const Fault& fault) { return fault.name == name; }));
  }
  return faults;
}

// The light is out for a third of the way, and the wheels or the gyro are wrong: nothing but the
// images behind the dark can show it.
std::vector<Fault> MotionFaults() {
  std::vector<Fault> faults = {{"none"}};
  const auto dark = [](const Recording& good, Random&) { return Dark(good); };
  const auto add = [&](const std::string& name, auto motion) {
    Fault fault{name};
    fault.recording = dark;
    fault.motion = motion;
    faults.push_back(fault);
  };
  faults.push_back(Images("dark for a third of the way", dark));
  add("dark, and no wheels for half of the way",
      [](const Motion& good, Random& random) { return MissingWheels(good, 0.5, random); });
  add("dark, and 10 slips of 0.3 m",
      [](const Motion& good, Random& random) { return SlippingWheels(good, 10, 0.3, random); });
  add("dark, and a clock that is 0.5 s late",
      [](const Motion& good, Random&) { return WrongClock(good, 0.5); });
  add("dark, and a clock that is an hour late",
      [](const Motion& good, Random&) { return WrongClock(good, 3600); });
  add("dark, and turns of the opposite sign",
      [](const Motion& good, Random&) { return OppositeTurns(good); });
  add("dark, and all motion of the opposite sign",
      [](const Motion& good, Random&) { return OppositeMotion(good); });
  add("dark, and wheels that count 1.2 times the way",
      [](const Motion& good, Random&) { return WrongScale(good, 1.2); });
  add("dark, and 10 % of rows twice or swapped",
      [](const Motion& good, Random& random) { return ShuffledRows(good, 0.1, random); });
  add("dark, and a gyro of the opposite sign",
      [](const Motion& good, Random&) { return OppositeGyro(good); });
  add("dark, and a gyro that is stuck",
      [](const Motion& good, Random& random) { return StuckGyro(good, random); });
  add("dark, and a gyro in degrees",
      [](const Motion& good, Random&) { return GyroInDegrees(good); });
  add("dark, and odometry (TUM) that jumps 3 times",
      [](const Motion& good, Random& random) { return JumpingPoses(good, 3, random); });
  faults.back().odometry = OdometryForm::kTum;
  for (const char* const line : {"nan,nan,nan", "\x01\xff;;;"}) {
    Fault fault{std::string("odometry with 3 lines ") +
                (line[0] == 'n' ? "that are not a number" : "of rubbish")};
    fault.odometry_text = [line](const std::string& text, Random& random) {
      return ReplaceLines(text, 3, line, random);
    };
    faults.push_back(fault);
  }
  return faults;
}

// Overwrites this number of places of 64 bytes with random ones, behind the beginning.
void DamageBytes(const fs::path& file, int places, Random& random) {
  constexpr std::size_t kBytes = 64;
  constexpr std::size_t kBeginning = 4096;
  std::string bytes = ReadBytes(file);
  std::uniform_int_distribution<int> value(0, 255);
  for (int i = 0; i < places; ++i) {
    const std::size_t at =
        std::uniform_int_distribution<std::size_t>(kBeginning, bytes.size() - kBytes)(random);
    for (std::size_t k = 0; k < kBytes; ++k) bytes[at + k] = static_cast<char>(value(random));
  }
  WriteBytes(file, bytes);
}

std::vector<Fault> BagFaults() {
  std::vector<Fault> faults = {{"none (MCAP)", {}, Storage::kMcap},
                               {"none (rosbag2)", {}, Storage::kRosbag2}};
  const auto add_file = [&](const std::string& name, Storage storage, auto file) {
    faults.push_back({name, {}, storage, file});
  };
  for (const auto& [name, storage] :
       {std::pair{"MCAP", Storage::kMcap}, {"rosbag2", Storage::kRosbag2}}) {
    add_file(name + std::string(" cut off at two thirds"),
             storage,
             [](const fs::path& bag, Random&) { Truncate(bag, 2.0 / 3); });
    add_file(name + std::string(", damaged at 10 places"),
             storage,
             [](const fs::path& bag, Random& random) { DamageBytes(bag, 10, random); });
  }
  const auto add = [&](const std::string& name, auto messages) {
    Fault fault{name, {}, Storage::kMcap};
    fault.messages = messages;
    faults.push_back(fault);
  };
  add("20 % of messages missing",
      [](BagMessages& messages, Random& random) { DropMessages(messages, 0.2, random); });
  add("20 % of messages twice",
      [](BagMessages& messages, Random& random) { DuplicateMessages(messages, 0.2, random); });
  add("20 % of messages recorded up to 0.5 s late",
      [](BagMessages& messages, Random& random) { DelayMessages(messages, 0.2, random); });
  add("images without stamps",
      [](BagMessages& messages, Random&) { ClearStamps(messages, "/up/image_raw"); });
  add("odometry without stamps",
      [](BagMessages& messages, Random&) { ClearStamps(messages, "/odom"); });
  Fault clock{"odometry and gyro stamped an hour late", {}, Storage::kMcap};
  clock.motion = [](const Motion& good, Random&) { return WrongClock(good, 3600); };
  faults.push_back(clock);
  return faults;
}

}  // namespace

const std::vector<FaultGroup>& AllGroups() {
  static const std::vector<FaultGroup> kGroups = {
      {"recordings", TilesRoom, RecordingFaults()},
      {"odometry", WheelsRoom, MotionFaults()},
      {"bags", WheelsRoom, BagFaults()},
      {"fisheye", FisheyeRoom, SomeRecordingFaults()},
      {"heights", RoomWithDepth, SomeRecordingFaults()}};
  return kGroups;
}

namespace {

template <typename Items>
const auto& Named(const Items& all, const std::string& name, const char* kind) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& item) { return item.name == name; });
  if (found == all.end()) {
    throw std::out_of_range(std::string("there is no ") + kind + " named '" + name + "'");
  }
  return *found;
}

}  // namespace

const FaultGroup& GroupNamed(const std::string& name) {
  return Named(AllGroups(), name, "group of faults");
}

const Fault& FaultNamed(const std::string& name, const std::string& group) {
  return Named(GroupNamed(group).faults, name, "fault");
}

}  // namespace ceilmap::faults
