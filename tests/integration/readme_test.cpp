// The command lines that the READMEs print.

#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap {
namespace {

namespace fs = std::filesystem;

/// A line that begins like this needs nothing but the repository and what the lines before it in
/// the same file wrote.
constexpr const char* kBuilt = "build/release/app/ceilmap";
constexpr const char* kInstalled = "ceilmap";

using Words = std::vector<std::string>;

/// Up to a comment.
Words SplitWords(const std::string& line) {
  std::istringstream stream(line);
  Words words;
  for (std::string word; stream >> word && word != "#";) words.push_back(word);
  return words;
}

/// The command lines of indented blocks that begin with ceilmap; continued lines are joined.
std::vector<Words> CommandsOf(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<Words> commands;
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("    ")) continue;
    for (std::string more; line.ends_with('\\') && std::getline(stream, more);) {
      line.pop_back();
      line += more;
    }
    Words words = SplitWords(line);
    if (words.size() > 1 && (words[0] == kBuilt || words[0] == kInstalled)) {
      commands.push_back(std::move(words));
    }
  }
  return commands;
}

std::vector<fs::path> Readmes() {
  const fs::path root = CEILMAP_SOURCE_DIR;
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(root); it != fs::recursive_directory_iterator();
       ++it) {
    const std::string name = it->path().filename().string();
    if (it->is_directory() && (name == "build" || name.starts_with('.'))) {
      it.disable_recursion_pending();
    } else if (it->path().extension() == ".md") {
      files.push_back(it->path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The words that name the subcommand, "compass learn".
Words SubcommandOf(const Words& command) {
  static const std::set<std::string> kGroups = {"compass", "calibrate"};
  Words subcommand = {command[1]};
  if (kGroups.contains(command[1]) && command.size() > 2) subcommand.push_back(command[2]);
  return subcommand;
}

std::string HelpOf(const Words& subcommand) {
  static std::map<Words, std::string> texts;
  const auto known = texts.find(subcommand);
  if (known != texts.end()) return known->second;
  Words arguments = subcommand;
  arguments.emplace_back("--help");
  return texts[subcommand] = support::RunCeilmap(arguments, ".").out;
}

TEST(Readme, CommandsAndOptionsExist) {
  int commands = 0;
  for (const fs::path& file : Readmes()) {
    for (const Words& command : CommandsOf(file)) {
      ++commands;
      const std::string help = HelpOf(SubcommandOf(command));
      EXPECT_THAT(help, testing::HasSubstr("Usage")) << file << ": " << command[1];
      for (const std::string& word : command) {
        if (!word.starts_with("--")) continue;
        const std::string option = word.substr(0, word.find('='));
        EXPECT_TRUE(std::regex_search(help, std::regex(option + "\\b(?!-)")))
            << file << ": " << command[1] << " has no " << option;
      }
    }
  }
  EXPECT_GT(commands, 50) << "of all READMEs";
}

TEST(Readme, CommandsOnBundledDataRun) {
  int run = 0;
  for (const fs::path& file : Readmes()) {
    const support::TestFolder folder;
    fs::create_directory_symlink(fs::path(CEILMAP_SOURCE_DIR) / "samples", folder / "samples");
    for (Words command : CommandsOf(file)) {
      if (command[0] != kBuilt) continue;
      command.erase(command.begin());
      ++run;
      const auto result = support::RunCeilmap(command, folder.Path().string());
      EXPECT_EQ(result.exit_code, 0) << file << ": " << testing::PrintToString(command) << '\n'
                                     << result.err;
    }
  }
  EXPECT_GT(run, 15) << "of all READMEs";
}

}  // namespace
}  // namespace ceilmap
