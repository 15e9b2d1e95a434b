// The command lines that the READMEs print.

#include <algorithm>
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
/// the same file wrote: it is run here.
constexpr const char* kBuilt = "build/release/app/ceilmap";
/// A line that begins like this needs files of the reader: a comment above it in its block, or
/// behind it, has the mark.
constexpr const char* kInstalled = "ceilmap";
constexpr const char* kOwnFiles = "own files";

using Words = std::vector<std::string>;

/// A line of an indented block; continued lines are joined.
struct Line {
  std::string text;
  bool own_files = false;  ///< it or a comment above it in its block has the mark

  /// Up to a comment.
  [[nodiscard]] Words SplitWords() const {
    std::istringstream stream(text);
    Words words;
    for (std::string word; stream >> word && word != "#";) words.push_back(word);
    return words;
  }
  [[nodiscard]] std::string FirstWord() const {
    const Words words = SplitWords();
    return words.empty() ? "" : words[0];
  }
  [[nodiscard]] bool IsCommand() const {
    const std::string word = FirstWord();
    return (word == kBuilt || word == kInstalled) && SplitWords().size() > 1;
  }
};

std::vector<Line> LinesOf(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<Line> lines;
  bool own_files = false;
  for (std::string text; std::getline(stream, text);) {
    if (!text.starts_with("    ")) {
      own_files = false;
      continue;
    }
    for (std::string more; text.ends_with('\\') && std::getline(stream, more);) {
      text.pop_back();
      text += more;
    }
    text.erase(0, text.find_first_not_of(' '));
    const bool marked = text.find(kOwnFiles) != std::string::npos;
    own_files = own_files || (marked && text.starts_with('#'));
    lines.push_back({text, own_files || marked});
  }
  return lines;
}

std::vector<Words> CommandsOf(const fs::path& file) {
  std::vector<Words> commands;
  for (const Line& line : LinesOf(file)) {
    if (line.IsCommand()) commands.push_back(line.SplitWords());
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
  static const std::set<std::string> kGroups = {"compass", "calibrate", "site"};
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

TEST(Readme, CommandsThatAreNotRunHereAreMarked) {
  for (const fs::path& file : Readmes()) {
    for (const Line& line : LinesOf(file)) {
      if (!line.IsCommand()) continue;
      EXPECT_EQ(line.own_files, line.FirstWord() == kInstalled)
          << file << ": " << line.text << "\nbegin it with " << kBuilt
          << " if it runs on what the repository holds; otherwise write '# " << kOwnFiles
          << ":' above it";
    }
  }
}

// Those of users; developers' scripts only have to exist.
TEST(Readme, ScriptsExistAndStateTheirTime) {
  const std::regex time("# .*([0-9] (s|min|h)\\b|minute|hour)");
  const fs::path root = CEILMAP_SOURCE_DIR;
  int scripts = 0;
  for (const fs::path& file : Readmes()) {
    for (const Line& line : LinesOf(file)) {
      const std::string script = line.FirstWord();
      if (!script.ends_with(".sh") || script.find('/') == std::string::npos) continue;
      ++scripts;
      EXPECT_TRUE(fs::exists(root / script)) << file << ": " << line.text;
      if (file != root / "README.md" && file != root / "samples/README.md") continue;
      EXPECT_TRUE(std::regex_search(line.text, time)) << file << ": " << line.text;
    }
  }
  EXPECT_GT(scripts, 10) << "of all READMEs";
}

/// True for a command that reads nothing but the repository and leaves nothing for later lines: it
/// does the same in every README.
bool StandsAlone(const Words& command, const fs::path& folder) {
  return std::all_of(command.begin() + 1, command.end(), [&](const std::string& word) {
    const bool is_bundled = word.starts_with("samples/") || !fs::exists(folder / word);
    return is_bundled && word != "-o" && word.find('$') == std::string::npos;
  });
}

TEST(Readme, CommandsOnBundledDataRun) {
  const std::regex assignment("[A-Z]+=.*");
  int run = 0;
  std::set<Words> alone;
  for (const fs::path& file : Readmes()) {
    const support::TestFolder folder;
    fs::create_directory_symlink(fs::path(CEILMAP_SOURCE_DIR) / "samples", folder / "samples");
    fs::create_directories((folder / kBuilt).parent_path());
    fs::create_symlink(CEILMAP_EXE, folder / kBuilt);
    std::string variables;
    for (const Line& line : LinesOf(file)) {
      const std::string word = line.FirstWord();
      if (std::regex_match(line.text, assignment)) variables += line.text + "\n";
      if (word != kBuilt && word != "echo") continue;
      run += word == kBuilt ? 1 : 0;
      const Words words = line.SplitWords();
      if (StandsAlone(words, folder.Path()) && !alone.insert(words).second) continue;
      const support::ProcessResult result =
          support::ChildProcess({"/bin/sh", "-c", variables + line.text}, folder.Path().string())
              .Wait();
      EXPECT_EQ(result.exit_code, 0) << file << ": " << line.text << '\n' << result.err;
    }
  }
  EXPECT_GT(run, 25) << "of all READMEs";
}

}  // namespace
}  // namespace ceilmap
