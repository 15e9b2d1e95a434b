#include "app/manual/completion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "tests/app/manual/sample_program.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::manual {
namespace {

/// What bash would offer behind `line`, in one line; calls of bash-completion's _filedir are shown.
std::string Offered(const std::string& line) {
  const SampleProgram sample;
  const support::TestFolder folder;
  const std::filesystem::path script = folder / "completion.bash";
  std::ofstream(script) << R"(
_filedir() { COMPREPLY=("files:$*"); }
_init_completion() {
    words=("${typed[@]}")
    cword=$((${#typed[@]} - 1))
    cur=${words[cword]}
    prev=${words[cword - 1]}
}
complete() { :; }
complete_line() {
    local -a COMPREPLY=() typed=("$@")
    _tool
    echo "${COMPREPLY[*]}"
}
)" << BashCompletion(sample.app, {"files"})
                        << "complete_line " << line << "\n";
  const std::string command = "bash '" + script.string() + "'";
  const std::unique_ptr<FILE, int (*)(FILE*)> bash(popen(command.c_str(), "r"), &pclose);
  std::array<char, 1000> answer{};
  if (std::fgets(answer.data(), answer.size(), bash.get()) == nullptr) return "no answer";
  const std::string text = answer.data();
  return text.substr(0, text.find('\n'));
}

TEST(BashCompletion, OffersCommands) {
  EXPECT_EQ(Offered("tool ''"), "draw store help");
  EXPECT_EQ(Offered("tool s"), "store");
  EXPECT_EQ(Offered("tool store ''"), "put");
}

TEST(BashCompletion, OffersCommandsAndTopicsBehindHelp) {
  EXPECT_EQ(Offered("tool help ''"), "files draw store help");
}

TEST(BashCompletion, OffersTheOptionsOfTheCommand) {
  EXPECT_EQ(Offered("tool draw --f"), "--format --folder");
  EXPECT_EQ(Offered("tool store put -"), "-h --help");
  EXPECT_EQ(Offered("tool draw a.gpkg --quiet --c"), "--count");
}

TEST(BashCompletion, OffersWhatAnOptionTakes) {
  EXPECT_EQ(Offered("tool draw --format ''"), "ros png");
  EXPECT_EQ(Offered("tool draw --format p"), "png");
  EXPECT_EQ(Offered("tool draw -o ''"), "files:@(pdf|svg)");
  EXPECT_EQ(Offered("tool draw --output ''"), "files:@(pdf|svg)");
  EXPECT_EQ(Offered("tool draw --folder ''"), "files:-d");
  EXPECT_EQ(Offered("tool draw --up ''"), "files:");
  EXPECT_EQ(Offered("tool draw --count ''"), "");
}

TEST(BashCompletion, OffersFilesForArguments) {
  EXPECT_EQ(Offered("tool draw ''"), "files:gpkg");
  EXPECT_EQ(Offered("tool draw --quiet ''"), "files:gpkg");
  EXPECT_EQ(Offered("tool store put ''"), "files:gpkg");
}

}  // namespace
}  // namespace ceilmap::manual
