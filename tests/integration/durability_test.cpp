// Killed at any moment, a run leaves the old map or the new one, and nothing that piles up.

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <csignal>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

#include "tests/integration/sites.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;

/// Counts what happens to the files of a folder: each creation, write, closing and renaming. These
/// are the moments at which being killed could matter, and they do not depend on the machine's
/// speed.
class FolderEvents {
 public:
  explicit FolderEvents(const std::filesystem::path& folder)
      : descriptor_(inotify_init1(IN_NONBLOCK)) {
    const auto watched = IN_CREATE | IN_MODIFY | IN_CLOSE_WRITE | IN_MOVE | IN_DELETE;
    if (inotify_add_watch(descriptor_, folder.c_str(), watched) < 0) {
      throw std::runtime_error("the folder cannot be watched");
    }
  }
  ~FolderEvents() { close(descriptor_); }
  FolderEvents(const FolderEvents&) = delete;
  FolderEvents& operator=(const FolderEvents&) = delete;

  /// Waits until a file takes the place of the named one; false when the program ended without.
  bool WaitForReplacement(const std::string& name, support::ChildProcess& child) {
    named_.clear();
    while (!named_.contains(name)) {
      if (child.WaitForDescriptor(descriptor_)) {
        (void)ReadSome();
      } else if (ReadSome() == 0) {  // ended, and nothing is left to be read
        return false;
      }
    }
    return true;
  }
  /// Waits for this number of events of the running program; @return the number before its end.
  int WaitFor(int count, support::ChildProcess& child) {
    int seen = 0;
    while (seen < count && child.WaitForDescriptor(descriptor_)) seen += ReadSome();
    return seen;
  }

 private:
  int ReadSome() {
    alignas(inotify_event) std::array<char, sizeof(inotify_event) + NAME_MAX + 1> buffer{};
    const ssize_t length = read(descriptor_, buffer.data(), buffer.size());
    int events = 0;
    for (ssize_t at = 0; at < length; ++events) {
      inotify_event event{};
      std::memcpy(&event, buffer.data() + at, sizeof(event));
      if ((event.mask & IN_MOVED_TO) != 0) named_.insert(buffer.data() + at + sizeof(event));
      at += static_cast<ssize_t>(sizeof(event) + event.len);
    }
    return events;
  }

  int descriptor_;
  std::set<std::string> named_;  // names that files were given
};

/// A command that replaces a map.
struct Replacing {
  std::vector<std::string> arguments;
  std::string old_map;  ///< what the target holds before
  int poses = 0;        ///< in the trajectory of the map that it makes
};

class Durability : public testing::Test {
 protected:
  static constexpr const char* kTarget = "m.gpkg";
  static constexpr int kTrials = 4;
  static constexpr int kUntilReplaced = -1;

  void Restore(const Replacing& command) const {
    sites_.recordings.out.Write(kTarget, command.old_map);
  }
  [[nodiscard]] std::string Make(const std::vector<std::string>& arguments,
                                 const std::string& map) const {
    const support::ProcessResult result = sites_.recordings.Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadAll(sites_.recordings.out / map);
  }

  /// Kills the command after this number of events (kUntilReplaced: as soon as the target is), or
  /// lets it end. @return how many came.
  int Run(const Replacing& command, int events) {
    Restore(command);
    std::vector<std::string> arguments = sites_.recordings.Resolve(command.arguments);
    arguments.insert(arguments.begin(), CEILMAP_EXE);
    FolderEvents folder(sites_.recordings.out.Path());
    support::ChildProcess child(arguments, sites_.recordings.out.Path());
    const int seen = events == kUntilReplaced
                         ? static_cast<int>(folder.WaitForReplacement(kTarget, child))
                         : folder.WaitFor(events, child);
    child.Send(SIGKILL);
    (void)child.Wait();
    return seen;
  }

  /// Whether the target holds the new map and not the old one; one of them it must be.
  [[nodiscard]] bool HoldsTheNew(const Replacing& command) const {
    const nlohmann::json info = sites_.Info(kTarget);
    if (ReadAll(sites_.recordings.out / kTarget) == command.old_map) return false;
    EXPECT_EQ(info["trajectory_poses"], command.poses) << "neither the old map nor the new one";
    return true;
  }

  void Survive(const Replacing& command) {
    const int all = Run(command, std::numeric_limits<int>::max());
    ASSERT_GT(all, 2 * kTrials);
    ASSERT_TRUE(HoldsTheNew(command));
    const std::vector<std::string> clean = sites_.recordings.out.Names();
    int replaced = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      // Anywhere, and every other time near the end, where the files take their places.
      std::uniform_int_distribution<int> moment(trial % 2 == 0 ? 1 : all - 8, all);
      Run(command, moment(random_));
      replaced += HoldsTheNew(command) ? 1 : 0;
      // A partial file and a lock for each file that is written, whatever was killed before.
      EXPECT_LE(sites_.recordings.out.Names().size(), clean.size() + 4);
    }
    std::printf("%d times killed, at events 1 to %d: %d times the old map, %d times the new one\n",
                kTrials,
                all,
                kTrials - replaced,
                replaced);
    EXPECT_EQ(Run(command, kUntilReplaced), 1);
    EXPECT_TRUE(HoldsTheNew(command)) << "killed as soon as the new map has its name";
    Restore(command);
    (void)Make(command.arguments, kTarget);
    EXPECT_EQ(sites_.recordings.out.Names(), clean) << "the next run leaves nothing behind";
  }

  const Sites sites_;

 private:
  std::mt19937 random_{20101121};
};

TEST_F(Durability, OfAMapThatIsMadeAnew) {
  Replacing command;
  command.old_map = Make(sites_.MapArguments("elsewhere", "old.gpkg"), "old.gpkg");
  command.arguments = sites_.MapArguments("second", kTarget);
  command.poses = Sites::kSecond;
  Survive(command);
}

TEST_F(Durability, OfAMapThatIsAppendedTo) {
  Replacing command;
  command.old_map = Make(sites_.MapArguments("first", "old.gpkg"), "old.gpkg");
  command.arguments = sites_.MapArguments("second", kTarget);
  command.arguments.emplace_back("--append");
  command.poses = Sites::kFirst + Sites::kSecond;
  Survive(command);
}

TEST_F(Durability, OfAMapThatIsMerged) {
  (void)Make(sites_.MapArguments("first", "a.gpkg"), "a.gpkg");
  (void)Make(sites_.MapArguments("second", "b.gpkg"), "b.gpkg");
  Replacing command;
  command.old_map = Make(sites_.MapArguments("elsewhere", "old.gpkg"), "old.gpkg");
  command.arguments = {"merge", "a.gpkg", "b.gpkg", "-o", kTarget, "--force"};
  command.poses = Sites::kFirst + Sites::kSecond;
  Survive(command);
}

}  // namespace
}  // namespace ceilmap::integration
