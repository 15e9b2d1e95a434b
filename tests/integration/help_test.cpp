// `ceilmap help`, and what the program answers to mistyped names.

#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string Answer(const std::vector<std::string>& arguments) {
  const support::ProcessResult result = support::RunCeilmap(arguments, ".");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  return result.out;
}

void ExpectRefused(const std::vector<std::string>& arguments, const std::string& message) {
  const support::ProcessResult result = support::RunCeilmap(arguments, ".");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "ceilmap: " + message + "\n");
}

TEST(Help, OfTheProgramAndOfACommandIsThatOfTheOption) {
  EXPECT_EQ(Answer({"help"}), Answer({"--help"}));
  EXPECT_EQ(Answer({"help", "--help"}), Answer({"--help"}));
  EXPECT_EQ(Answer({"help", "map"}), Answer({"map", "--help"}));
  EXPECT_EQ(Answer({"help", "compass", "learn"}), Answer({"compass", "learn", "--help"}));
}

TEST(Help, PrintsItsTopics) {
  EXPECT_THAT(Answer({"help", "FILES"}), StartsWith("# Files that ceilmap reads and writes\n"));
  EXPECT_THAT(Answer({"help", "troubleshooting"}), HasSubstr("give --force to replace it"));
}

TEST(Help, OfEveryCommandNamesTheTopics) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{}, {"map"}, {"localize"}, {"compass", "query"}, {"simulate"}}) {
    std::vector<std::string> arguments = command;
    arguments.emplace_back("--help");
    EXPECT_THAT(Answer(arguments), HasSubstr("help troubleshooting'"));
    EXPECT_THAT(Answer(arguments), HasSubstr("'ceilmap help files'"));
  }
}

TEST(Help, SuggestsTheCommandThatWasMeant) {
  ExpectRefused({"mpa"},
                "there is no command 'mpa'; did you mean 'map'? 'ceilmap --help' lists them");
  ExpectRefused({"fly-away"}, "there is no command 'fly-away'; 'ceilmap --help' lists them");
  ExpectRefused({"compass", "lern"},
                "there is no command 'compass lern'; did you mean 'learn'? 'ceilmap compass "
                "--help' lists them");
  ExpectRefused(
      {"help", "file"},
      "there is no command or topic 'file'; did you mean 'files'? 'ceilmap --help' lists them");
}

TEST(Help, SuggestsTheOptionThatWasMeant) {
  ExpectRefused({"map", "--up=u", "--stmaps=s.csv", "-o", "m.gpkg"},
                "there is no option '--stmaps' of 'ceilmap map'; did you mean '--stamps'? "
                "'ceilmap map --help' lists them");
  // Before what is missing.
  ExpectRefused({"map", "--upp", "u"},
                "there is no option '--upp' of 'ceilmap map'; did you mean '--up'? 'ceilmap map "
                "--help' lists them");
  ExpectRefused({"calibrate", "camera", "--cornes=9x6"},
                "there is no option '--cornes' of 'ceilmap calibrate camera'; did you mean "
                "'--corners'? 'ceilmap calibrate camera --help' lists them");
  ExpectRefused({"--versoin"},
                "there is no option '--versoin' of 'ceilmap'; did you mean '--version'? 'ceilmap "
                "--help' lists them");
  ExpectRefused(
      {"info", "m.gpkg", "--everything"},
      "there is no option '--everything' of 'ceilmap info'; 'ceilmap info --help' lists them");
}

}  // namespace
}  // namespace ceilmap::integration
