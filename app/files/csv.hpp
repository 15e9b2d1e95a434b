#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::files {

/// A comma-separated file with a header line, held in memory. Quoted fields ("a, b", doubled quotes
/// for a quote) are understood within a line; blank lines are skipped; a byte order mark and CRLF
/// line ends do no harm.
struct CsvTable {
  struct Row {
    int line = 0;  ///< in the file, from 1
    std::vector<std::string> fields;
  };
  std::string name;  ///< of the file, for messages
  std::vector<std::string> header;
  std::vector<Row> rows;  ///< each with as many fields as the header

  /// Position of a column. @throws InputError when there is no such column.
  [[nodiscard]] std::size_t Column(std::string_view column) const;
  /// Whether there is one.
  [[nodiscard]] bool Has(std::string_view column) const;
  /// The number in a row's field. @throws InputError when it is none, or not finite.
  [[nodiscard]] double Number(const Row& row, std::size_t column) const;
  /// `NAME:LINE`, the start of a message about a row.
  [[nodiscard]] std::string Place(const Row& row) const;
};

/// Fields that a file may have at most: each costs some 40 bytes.
inline constexpr std::size_t kMaxCsvFields = 30'000'000;

/// @throws InputError when the file is missing or too large (app/text_file.hpp), has no
///   header, a row has another number of fields than the header, or there are too many.
CsvTable ReadCsv(const std::filesystem::path& file);

/// The same from a file's text. @param name  the file's, for messages. @param max_fields  for
///   tests.
CsvTable ParseCsv(std::string_view text, std::string name, std::size_t max_fields = kMaxCsvFields);

/// The field as CSV: quoted where it must be.
std::string CsvField(std::string_view text);

/// The number that the whole text spells, finite or not; false when it spells none.
bool ParseNumber(std::string_view text, double& number);

}  // namespace ceilmap::files
