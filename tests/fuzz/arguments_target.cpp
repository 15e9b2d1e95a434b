#include <string>
#include <vector>

#include "app/files/arguments.hpp"
#include "app/live/page_server.hpp"
#include "app/program.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

std::vector<std::string> Words(std::string_view bytes) {
  constexpr std::size_t kMax = 64;
  std::vector<std::string> words;
  while (!bytes.empty() && words.size() < kMax) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    words.emplace_back(
        bytes.substr(0, end).substr(0, bytes.find('\0')));  // as the system gives them
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
  return words;
}

}  // namespace

void ReadAsCommandLine(std::string_view bytes) {
  const std::vector<std::string> words = Words(bytes);
  std::vector<const char*> argv = {"ceilmap"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  // Made once: it takes as long as a hundred command lines.
  static app::CommandLine line;
  try {
    const commands::Command* const command = line.Parse(static_cast<int>(argv.size()), argv.data());
    Require(command != nullptr ? bool(command->run) : !line.Answer().empty(), "nothing to do");
  } catch (const InputError& error) {
    Require(*error.what() != '\0', "an error without a text");  // the console makes it one line
  }
}

void ReadAsArguments(std::string_view bytes) {
  const std::string text(bytes);
  const auto refuse_or_take = [](const auto& parse) {
    try {
      (void)parse();
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch)
    }
  };
  refuse_or_take([&] { return files::ParsePose2(text, "--start"); });
  refuse_or_take([&] { return files::ParseSpread(text, "--start-spread"); });
  refuse_or_take([&] { return files::ParsePositiveNumbers(text, "--segments"); });
  refuse_or_take([&] {
    const live::ServerAddress address = live::ParseServerAddress(text, "--live-at");
    Require(address.port >= 0 && address.port <= 65535 && !address.host.empty(), "an address");
    return address;
  });
  (void)files::ParseFourNumbers(text);
  (void)files::ParseSixNumbers(text);
  if (text.find('\0') == std::string::npos) (void)files::ParseNamedFile(text);
}

}  // namespace ceilmap::fuzz
