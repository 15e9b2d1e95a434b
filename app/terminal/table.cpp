#include "app/terminal/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

namespace ceilmap::terminal {
namespace {

bool IsNumberLike(const std::string& cell) {
  const bool sign = cell.starts_with('-') || cell.starts_with('+') || cell.starts_with('.');
  const std::size_t first = sign ? 1 : 0;
  return cell.size() > first && std::isdigit(static_cast<unsigned char>(cell[first])) != 0;
}

}  // namespace

void Table::AddRow(std::vector<std::string> cells) {
  rows_.push_back(std::move(cells));
}

std::string Table::Format(Numbers numbers) const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) line += "  ";
      const bool right = numbers == Numbers::kRight && i > 0 && IsNumberLike(row[i]);
      line += fmt::format(fmt::runtime(right ? "{:>{}}" : "{:<{}}"), row[i], widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

}  // namespace ceilmap::terminal
