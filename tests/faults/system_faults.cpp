#include "tests/faults/system_faults.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <stdexcept>
#include <thread>

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

using support::ChildProcess;
using support::ProcessResult;

constexpr int kKilled = 128 + SIGKILL;

// A few frames are enough to be written: the map of the first twenty images.
constexpr int kFrames = 20;

/// A folder with an old map in it, and the command that replaces it.
class Target {
 public:
  explicit Target(const Lab& lab) : lab_(lab), folder_(lab.Folder() / "target") {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::remove_all(lab.Folder() / "short");
    fs::create_directories(lab.Folder() / "short");
    (void)StoreImages(Shots(), lab.Folder() / "short", Storage::kImages);
    WriteBytes(lab.Folder() / "short.csv", StampsText(Shots()));
    Restore();
  }

  void Restore() {
    fs::copy_file(lab_.Folder() / "good.gpkg", Map(), fs::copy_options::overwrite_existing);
    before_ = ReadBytes(Map());
  }
  [[nodiscard]] fs::path Map() const { return folder_ / "m.gpkg"; }
  [[nodiscard]] MapState State() const { return lab_.StateOf(Map(), before_); }

  [[nodiscard]] std::vector<std::string> Command() const {
    std::vector<std::string> arguments =
        Lab::MapArguments({"--up=short/up", "--stamps=short.csv"}, Map().string());
    arguments.insert(arguments.begin(), CEILMAP_EXE);
    return arguments;
  }
  /// Runs it while the disk fails in the folder.
  [[nodiscard]] ProcessResult RunOnBadDisk(const std::string& fault, long after) const {
    const std::string preload = std::string("LD_PRELOAD=") + CEILMAP_DISK_FAULTS;
    std::vector<std::string> arguments = {
        "/usr/bin/env",
        preload,
        "ASAN_OPTIONS=verify_asan_link_order=0",
        "CEILMAP_FAULT=" + fault,
        "CEILMAP_FAULT_FOLDER=" + folder_.string(),
        "CEILMAP_FAULT_AFTER=" + std::to_string(after),
        "CEILMAP_FAULT_COUNT=" + (lab_.Folder() / "calls").string(),
    };
    const std::vector<std::string> command = Command();
    arguments.insert(arguments.end(), command.begin(), command.end());
    return ChildProcess(arguments, lab_.Folder().string()).Wait();
  }
  /// How many calls change files when nothing fails.
  [[nodiscard]] int CountCalls() const {
    (void)RunOnBadDisk("none", 0);
    int calls = 0;
    std::ifstream(lab_.Folder() / "calls") >> calls;
    return calls;
  }
  [[nodiscard]] Recording Shots() const {
    return {lab_.Mapped().begin(), lab_.Mapped().begin() + kFrames};
  }

 private:
  const Lab& lab_;
  fs::path folder_;
  std::string before_;
};

void Count(const ProcessResult& run, bool as_expected, MapState state, SystemResult& result) {
  const Outcome outcome = OutcomeOf(run, {});
  ++result.trials;
  if (!outcome.message.empty()) result.message = outcome.message;
  result.disorderly += as_expected ? 0 : 1;
  result.old_maps += state == MapState::kOld ? 1 : 0;
  result.new_maps += state == MapState::kNew ? 1 : 0;
  result.lost_maps += state == MapState::kLost ? 1 : 0;
  const bool known =
      std::find(result.codes.begin(), result.codes.end(), run.exit_code) != result.codes.end();
  if (!known) result.codes.push_back(run.exit_code);
}

// Anywhere, and every other time among the last, where files take their names.
long Moment(int trial, int calls, Random& random) {
  constexpr int kLast = 12;
  const int first = trial % 2 == 0 ? 0 : std::max(0, calls - kLast);
  return std::uniform_int_distribution<long>(first, calls - 1)(random);
}

// Motion JPEG into a pipe, to and fro through the images, until the reader stops.
class Feed {
 public:
  Feed(const fs::path& pipe, const Recording& shots) {
    (void)std::signal(SIGPIPE, SIG_IGN);
    fs::remove(pipe);
    if (mkfifo(pipe.c_str(), 0600) != 0) throw std::runtime_error("no pipe");
    std::vector<std::string> images;
    for (const Shot& shot : shots) {
      std::vector<unsigned char> code;
      cv::imencode(".jpg", shot.image, code);
      images.emplace_back(code.begin(), code.end());
    }
    images.insert(images.end(), images.rbegin(), images.rend());
    writer_ = std::thread([pipe, images] {
      std::ofstream stream(pipe, std::ios::binary);
      for (std::size_t i = 0; stream; i = (i + 1) % images.size()) stream << images[i];
    });
  }
  ~Feed() { writer_.join(); }
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

 private:
  std::thread writer_;
};

struct WriteFault {
  std::string name;
  std::string fault;  // CEILMAP_FAULT
};

// The fault at a write chosen at random, again and again.
SystemResult AtWrites(const Lab& lab,
                      const WriteFault& fault,
                      int trials,
                      unsigned seed,
                      const std::function<bool(const ProcessResult&, MapState)>& orderly) {
  SystemResult result;
  result.name = fault.name;
  Target target(lab);
  const int calls = target.CountCalls();
  Random random(seed);
  for (int trial = 0; trial < trials; ++trial) {
    target.Restore();
    const ProcessResult run = target.RunOnBadDisk(fault.fault, Moment(trial, calls, random));
    const MapState state = target.State();
    Count(run, orderly(run, state), state, result);
  }
  return result;
}

}  // namespace

SystemResult DiskFull(const Lab& lab, int trials, unsigned seed) {
  // After the renaming nothing but the folder's sync is left to fail.
  return AtWrites(lab,
                  {"disk full at a write", "full"},
                  trials,
                  seed,
                  [](const ProcessResult& run, MapState s) {
                    const Outcome outcome = OutcomeOf(run, {});
                    return outcome.orderly && (outcome.exit_code == 0) <= (s == MapState::kNew);
                  });
}

SystemResult KilledAtAWrite(const Lab& lab, int trials, unsigned seed) {
  return AtWrites(
      lab, {"killed at a write", "kill"}, trials, seed, [](const ProcessResult& run, MapState) {
        return run.exit_code == kKilled || run.exit_code == 0;
      });
}

SystemResult ReadOnlyFolder(const Lab& lab) {
  SystemResult result;
  result.name = "read-only folder";
  const Target target(lab);
  const ProcessResult run = target.RunOnBadDisk("readonly", 0);
  const Outcome outcome = OutcomeOf(run, {});
  const MapState state = target.State();
  Count(run, outcome.orderly && outcome.exit_code == 2 && state == MapState::kOld, state, result);
  return result;
}

SystemResult TwoWriters(const Lab& lab) {
  SystemResult result;
  result.name = "two `map` of one name";
  const Target target(lab);
  const Feed feed(lab.Folder() / "pipe", target.Shots());
  const fs::path map = target.Map();
  ChildProcess first(
      {CEILMAP_EXE, "map", "--rig=mapped.yaml", "--up=pipe", "-o", map.string(), "--force"},
      lab.Folder().string());
  // It writes from then on, and for as long as there are images.
  const fs::path partial = map.parent_path() / ".m.gpkg.partial";
  std::error_code ignored;
  while (!fs::exists(partial, ignored) || fs::file_size(partial, ignored) == 0) {
    std::this_thread::yield();
  }
  const ProcessResult second = ChildProcess(target.Command(), lab.Folder().string()).Wait();
  const Outcome refused = OutcomeOf(second, {});
  Count(second, refused.orderly && refused.exit_code == 2, target.State(), result);
  first.Send(SIGINT);
  const ProcessResult done = first.Wait();
  const MapState state = target.State();
  Count(done, done.exit_code == 0 && state == MapState::kNew, state, result);
  return result;
}

SystemResult ReplacedWhileRead(const Lab& lab) {
  SystemResult result;
  result.name = "`localize` on a map that `map` replaces";
  const Target target(lab);
  const Feed feed(lab.Folder() / "pipe", target.Shots());
  ChildProcess reader({CEILMAP_EXE,
                       "localize",
                       target.Map().string(),
                       "--rig=mapped.yaml",
                       "--up=pipe",
                       "-o",
                       "t.tum",
                       "--force",
                       "--verbose"},
                      lab.Folder().string());
  (void)reader.WaitForErr("s: tracking");
  const ProcessResult writer = ChildProcess(target.Command(), lab.Folder().string()).Wait();
  Count(writer, writer.exit_code == 0, target.State(), result);
  reader.Send(SIGINT);
  const ProcessResult read = reader.Wait();
  Count(read, read.exit_code == 0, target.State(), result);
  return result;
}

}  // namespace ceilmap::faults
