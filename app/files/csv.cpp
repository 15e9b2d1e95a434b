#include "app/files/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "app/files/text_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::files {
namespace {

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string> SplitLine(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = Trim(field);
  return fields;
}

}  // namespace

std::size_t CsvTable::Column(std::string_view column) const {
  const auto found = std::find(header.begin(), header.end(), column);
  if (found == header.end()) {
    throw InputError(fmt::format(
        "{}:1: has no column '{}'; the first line must name the columns", name, column));
  }
  return static_cast<std::size_t>(found - header.begin());
}

bool CsvTable::Has(std::string_view column) const {
  return std::find(header.begin(), header.end(), column) != header.end();
}

double CsvTable::Number(const Row& row, std::size_t column) const {
  const std::string& field = row.fields[column];
  double number = 0;
  if (!ParseNumber(field, number) || !std::isfinite(number)) {
    throw InputError(fmt::format(
        "{}: {} '{}' is not a number", Place(row), Shown(header[column]), Shown(field)));
  }
  return number;
}

std::string CsvTable::Place(const Row& row) const {
  return fmt::format("{}:{}", name, row.line);
}

CsvTable ReadCsv(const std::filesystem::path& file) {
  return ParseCsv(ReadTextFile(file), file.string());
}

CsvTable ParseCsv(std::string_view text, std::string name, std::size_t max_fields) {
  CsvTable table;
  table.name = std::move(name);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  Lines lines(text, table.name);
  std::string_view line;
  while (lines.Next(line)) {
    if (Trim(line).empty()) continue;
    if (table.header.empty()) {
      table.header = SplitLine(line);
      continue;
    }
    CsvTable::Row row{lines.Number(), SplitLine(line)};
    if (row.fields.size() != table.header.size()) {
      throw InputError(fmt::format("{}: {} fields, the header has {}",
                                   table.Place(row),
                                   row.fields.size(),
                                   table.header.size()));
    }
    if ((table.rows.size() + 1) * table.header.size() > max_fields) {
      throw InputError(fmt::format(
          "{}: more than {} fields; split the recording", table.Place(row), max_fields));
    }
    table.rows.push_back(std::move(row));
  }
  if (table.header.empty()) throw InputError(fmt::format("{}: is empty", table.name));
  return table;
}

std::string CsvField(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

bool ParseNumber(std::string_view text, double& number) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace ceilmap::files
