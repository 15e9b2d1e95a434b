// `ceilmap prune` through the real program, and the history through commands that make a map anew.

#include <nlohmann/json.hpp>

#include "mapping/store/map_file.hpp"
#include "mapping/store/map_revision.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::UnorderedElementsAre;

class PruneCommand : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(Map({}).exit_code, 0); }

  /// The same drive twice more.
  void Append() const {
    for (int i = 0; i < 2; ++i) ASSERT_EQ(Map({"--append"}).exit_code, 0);
  }

  [[nodiscard]] support::ProcessResult Map(std::vector<std::string> more) const {
    more.insert(
        more.begin(),
        {"map", "--quiet", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-om.gpkg"});
    return test_.Run(more);
  }
  [[nodiscard]] nlohmann::json History(const std::string& map) const {
    return nlohmann::json::parse(test_.Run({"info", map, "--changes", "--json"}).out);
  }

  Recordings test_;
};

TEST_F(PruneCommand, ASmallerMapLocalizesAndGrowsAsBefore) {
  Append();
  const std::size_t keyframes = store::MapReader(test_.out / "m.gpkg").ReadKeyframes().size();
  const support::ProcessResult result =
      test_.Run({"prune", "m.gpkg", "--redundant", "-o", "p.gpkg", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg", "p.gpkg", "s.json"));
  for (const char* text : {"keyframes", "removed", "MB, before", "written p.gpkg"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const std::size_t left = store::MapReader(test_.out / "p.gpkg").ReadKeyframes().size();
  EXPECT_LT(left, keyframes);
  const support::ProcessResult localized =
      test_.Run(LocalizeArguments("p.gpkg", "@rig.yaml", "@run.avi"));
  EXPECT_EQ(localized.exit_code, 0) << localized.err;
  const support::ProcessResult before =
      test_.Run(LocalizeArguments("m.gpkg", "@rig.yaml", "@run.avi"));
  const auto placed = [](const std::string& out) {
    return out.substr(out.find("on the map"), out.find(" frames") - out.find("on the map"));
  };
  EXPECT_EQ(placed(localized.out), placed(before.out));
  EXPECT_THAT(placed(before.out), HasSubstr(" of 24"));
  // The history of the map is kept by what is made of it.
  EXPECT_EQ(test_
                .Run({"map",
                      "--quiet",
                      "--rig=@rig.yaml",
                      "--up=@run.avi",
                      "--stamps=@stamps.csv",
                      "--append",
                      "-op.gpkg"})
                .exit_code,
            0);
  EXPECT_EQ(History("p.gpkg").at("sessions").size(), 3U);
  EXPECT_EQ(test_.Run({"merge", "m.gpkg", "p.gpkg", "-o", "s.gpkg", "--quiet"}).exit_code, 0);
  const nlohmann::json sessions = History("s.gpkg").at("sessions");
  ASSERT_EQ(sessions.size(), 5U);
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    EXPECT_EQ(sessions[i].at("id"), i + 1);
    EXPECT_EQ(sessions[i].at("placed"), kFrames);
  }
}

TEST_F(PruneCommand, UpdateRetiresKeyframesOnlyWithABudget) {
  Append();
  const auto update = [this](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"update", "m.gpkg", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv"});
    return test_.Run(more);
  };
  const std::size_t keyframes = store::MapReader(test_.out / "m.gpkg").ReadKeyframes().size();
  EXPECT_EQ(update({}).exit_code, 0);
  EXPECT_EQ(store::MapReader(test_.out / "m.gpkg").ReadKeyframes().size(), keyframes);
  const support::ProcessResult result = update({"--size-budget=0.01"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("removed"));
  EXPECT_THAT(result.err, HasSubstr("larger than the budget"));
  EXPECT_LT(store::MapReader(test_.out / "m.gpkg").ReadKeyframes().size(), keyframes);
  EXPECT_EQ(History("m.gpkg").at("sessions").size(), 4U);
}

TEST_F(PruneCommand, BadInputIsOneLineAndChangesNothing) {
  const std::uint64_t bytes = store::MapReader(test_.out / "m.gpkg").FileBytes();
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& text) {
    const support::ProcessResult result = test_.Run(arguments);
    EXPECT_EQ(result.exit_code, 2) << text;
    EXPECT_THAT(result.err, HasSubstr(text));
  };
  expect({"prune", "m.gpkg"}, "--before, --redundant or --size-budget");
  expect({"prune", "m.gpkg", "--before=monday"}, "is no date");
  expect({"prune", "m.gpkg", "--size-budget=-1"}, "--size-budget");
  expect({"prune", "none.gpkg", "--redundant"}, "none.gpkg");
  expect({"prune", "m.gpkg", "--redundant", "-o", "p.map"}, "must end in .gpkg");
  {
    const store::MapRevision other(test_.out / "m.gpkg", test_.out / "m.gpkg", "");
    expect({"prune", "m.gpkg", "--redundant"}, "m.gpkg");
  }
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg"));
  EXPECT_EQ(store::MapReader(test_.out / "m.gpkg").FileBytes(), bytes);
}

}  // namespace
}  // namespace ceilmap::integration
