#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::files {

/// A comma-separated file with a header line, held in memory. Quoted fields ("a, b", doubled quotes
/// for a quote) may not contain line breaks; blank lines are skipped; a byte order mark and CRLF
/// line ends are allowed.
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
  /// True when the table has the column.
  [[nodiscard]] bool Has(std::string_view column) const;
  /// The number in a field. @throws InputError when it is not a finite number.
  [[nodiscard]] double Number(const Row& row, std::size_t column) const;
  /// `NAME:LINE`, the beginning of a message about a row.
  [[nodiscard]] std::string Place(const Row& row) const;
};

/// Maximum number of fields of a file; each needs about 40 bytes.
inline constexpr std::size_t kMaxCsvFields = 30'000'000;

/// @throws InputError when the file is missing or too large (app/files/text_file.hpp), has no
/// header, a row has another number of fields than the header, or there are too many fields.
CsvTable ReadCsv(const std::filesystem::path& file);

/// The same from the text of a file. @param name  Its name in messages. @param max_fields  For
/// tests.
CsvTable ParseCsv(std::string_view text, std::string name, std::size_t max_fields = kMaxCsvFields);

/// A field as CSV, quoted if necessary.
std::string CsvField(std::string_view text);

/// Parses the whole text as a number, finite or not; false when it is not a number.
bool ParseNumber(std::string_view text, double& number);

}  // namespace ceilmap::files
