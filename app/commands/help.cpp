#include "app/commands/help.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "app/commands/help_texts.hpp"

namespace ceilmap::commands {
namespace {

constexpr std::size_t kMaxColumns = 90;

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

// The cells of `| a | b | c |`.
std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) cells.push_back(Trimmed(cell));
  return cells;
}

void AppendWrapped(const std::string& text, std::size_t indent, std::string& to) {
  std::istringstream words(text);
  std::string line(indent, ' ');
  for (std::string word; words >> word;) {
    const bool first = line.size() == indent;
    if (!first && line.size() + 1 + word.size() > kMaxColumns) {
      to += line + '\n';
      line = std::string(indent, ' ') + word;
    } else {
      line += (first ? "" : " ") + word;
    }
  }
  to += line + '\n';
}

}  // namespace

std::string TableAsParagraphs(std::string_view markdown) {
  std::istringstream stream{std::string(markdown)};
  std::string text;
  int row = 0;
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with('|')) {
      text += line + '\n';
      continue;
    }
    constexpr int kHeadingRows = 2;
    if (++row <= kHeadingRows) continue;
    const std::vector<std::string> cells = CellsOf(line);
    for (std::size_t i = 0; i < cells.size(); ++i) AppendWrapped(cells[i], i == 0 ? 0 : 4, text);
    text += '\n';
  }
  return text;
}

std::vector<std::string> HelpTopics() {
  return {"files", "troubleshooting"};
}

std::optional<std::string> HelpOn(std::string_view topic) {
  std::string name(topic);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (name == "files") return std::string(FilesText());
  if (name == "troubleshooting") return TableAsParagraphs(TroubleshootingText());
  return std::nullopt;
}

}  // namespace ceilmap::commands
