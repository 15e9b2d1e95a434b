// Killed at any moment, a run leaves the old map or the new one, and nothing that piles up.

#include <chrono>
#include <csignal>
#include <random>
#include <thread>

#include "tests/integration/sites.hpp"

namespace ceilmap::integration {
namespace {

using app::ReadAll;
using std::chrono::steady_clock;

/// A command that replaces a map.
struct Replacing {
  std::vector<std::string> arguments;
  std::string old_map;  ///< what the target holds before
  int poses = 0;        ///< in the trajectory of the map that it makes
};

class Durability : public testing::Test {
 protected:
  static constexpr const char* kTarget = "m.gpkg";
  static constexpr int kTrials = 7;

  void Restore(const Replacing& command) const {
    sites_.recordings.out.Write(kTarget, command.old_map);
  }
  [[nodiscard]] std::string Make(const std::vector<std::string>& arguments,
                                 const std::string& map) const {
    const ProcessResult result = sites_.recordings.Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadAll(sites_.recordings.out / map);
  }

  /// Kills the command after that time. @return whether the target holds the new map.
  bool KillAfter(const Replacing& command, std::chrono::microseconds delay) {
    Restore(command);
    std::vector<std::string> arguments = sites_.recordings.Resolve(command.arguments);
    arguments.insert(arguments.begin(), CEILMAP_EXE);
    ChildProcess child(arguments, sites_.recordings.out.Path());
    std::this_thread::sleep_for(delay);
    child.Send(SIGKILL);
    (void)child.Wait();
    const nlohmann::json info = sites_.Info(kTarget);
    if (ReadAll(sites_.recordings.out / kTarget) == command.old_map) return false;
    EXPECT_EQ(info["trajectory_poses"], command.poses) << "neither the old map nor the new one";
    return true;
  }

  void Survive(const Replacing& command) {
    Restore(command);
    const auto start = steady_clock::now();
    (void)Make(command.arguments, kTarget);
    const auto whole =
        std::chrono::duration_cast<std::chrono::microseconds>(steady_clock::now() - start).count();
    const std::vector<std::string> clean = sites_.recordings.out.Names();
    int replaced = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      // Anywhere, and every other time near the end, where the files take their places.
      std::uniform_real_distribution<double> part(trial % 2 == 0 ? 0.0 : 0.85, 1.0);
      const double moment = part(random_) * static_cast<double>(whole);
      if (KillAfter(command, std::chrono::microseconds(static_cast<std::int64_t>(moment)))) {
        ++replaced;
      }
      // One partial file for each file that is written, whatever was killed before.
      EXPECT_LE(sites_.recordings.out.Names().size(), clean.size() + 2);
    }
    std::printf("%d times killed: %d times the old map, %d times the new one\n",
                kTrials,
                kTrials - replaced,
                replaced);
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
  command.arguments = {"merge", "a.gpkg", "b.gpkg", "-o", kTarget};
  command.poses = Sites::kFirst + Sites::kSecond;
  Survive(command);
}

}  // namespace
}  // namespace ceilmap::integration
