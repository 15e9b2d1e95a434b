#pragma once

#include <string>
#include <vector>

namespace ceilmap::terminal {

/// A table for people: columns as wide as their content, two blanks apart.
class Table {
 public:
  /// Where cells stand that start with a number; the first column and words stand to the left.
  enum class Numbers { kLeft, kRight };

  void AddRow(std::vector<std::string> cells);
  [[nodiscard]] const std::vector<std::vector<std::string>>& Rows() const { return rows_; }
  /// Lines with a line feed each, without blanks at their ends.
  [[nodiscard]] std::string Format(Numbers numbers = Numbers::kRight) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace ceilmap::terminal
