#pragma once

#include <string>
#include <vector>

namespace ceilmap::terminal {

/// A table for terminals: columns as wide as their content, two blanks apart.
class Table {
 public:
  /// Alignment of cells that begin with a number; the first column and words are left-aligned.
  enum class Numbers { kLeft, kRight };

  void AddRow(std::vector<std::string> cells);
  [[nodiscard]] const std::vector<std::vector<std::string>>& Rows() const { return rows_; }
  /// Lines with line feeds, without trailing blanks.
  [[nodiscard]] std::string Format(Numbers numbers = Numbers::kRight) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace ceilmap::terminal
