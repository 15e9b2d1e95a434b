// `ceilmap update` through the real program: a recording of the same ceiling, and one with a
// banner.

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "mapping/store/map_file.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::UnorderedElementsAre;

class UpdateCommand : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(test_
                  .Run({"map",
                        "--quiet",
                        "--rig=@rig.yaml",
                        "--up=@run.avi",
                        "--stamps=@stamps.csv",
                        "-o",
                        "m.gpkg"})
                  .exit_code,
              0);
  }

  [[nodiscard]] support::ProcessResult Update(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "update", "m.gpkg", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv"};
    words.insert(words.end(), more.begin(), more.end());
    return test_.Run(words);
  }

  Recordings test_;
};

TEST_F(UpdateCommand, TheSameCeilingAddsASessionOnly) {
  const support::ProcessResult result = Update({"--trajectory=t.tum", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg", "t.tum", "s.json"));
  for (const char* text : {"session", "on the map", "changed", "0 places", "written m.gpkg"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const support::ProcessResult changes = test_.Run({"info", "m.gpkg", "--changes"});
  EXPECT_EQ(changes.exit_code, 0);
  EXPECT_THAT(changes.out, HasSubstr("run.avi"));
  const auto json = nlohmann::json::parse(test_.Run({"info", "m.gpkg", "--changes", "--json"}).out);
  EXPECT_EQ(json.at("sessions").size(), 1U);
  EXPECT_TRUE(json.at("changes").empty());
}

TEST_F(UpdateCommand, BadInputIsOneLineAndChangesNothing) {
  EXPECT_THAT(test_.Run({"info", "m.gpkg", "--changes"}).out, HasSubstr("never updated"));
  const auto expect = [&](const std::vector<std::string>& more, const std::string& text) {
    const support::ProcessResult result = Update(more);
    EXPECT_EQ(result.exit_code, 2) << text;
    EXPECT_THAT(result.err, HasSubstr(text));
  };
  expect({"--uncompensated=u.tum"}, "--uncompensated");
  expect({"-o", "new.map"}, "must end in .gpkg");
  expect({"--trajectory=m.gpkg"}, "m.gpkg");
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg"));
  EXPECT_TRUE(store::MapReader(test_.out / "m.gpkg").ReadHistory().sessions.empty());
}

}  // namespace
}  // namespace ceilmap::integration
