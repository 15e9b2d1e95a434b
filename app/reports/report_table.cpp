#include "app/reports/report_table.hpp"

#include <algorithm>
#include <cstddef>

#include "app/files/csv.hpp"
#include "app/terminal/table.hpp"

namespace ceilmap::reports {
namespace {

// Numbers, and cells without a number.
std::vector<bool> NumberColumns(const ReportTable& table) {
  std::vector<bool> numbers(table.columns.size(), !table.rows.empty());
  for (const std::vector<std::string>& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      double number = 0;
      numbers[i] = numbers[i] && (row[i].empty() || files::ParseNumber(row[i], number));
    }
  }
  return numbers;
}

std::string Join(const std::vector<std::string>& cells,
                 std::string_view between,
                 std::string (*escape)(std::string_view)) {
  std::string text;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) text += between;
    text += escape(cells[i]);
  }
  return text;
}

bool IsControl(char c) {
  const auto code = static_cast<unsigned char>(c);
  return code < 0x20 || code == 0x7F;
}

}  // namespace

std::string EscapeMarkdown(std::string_view text) {
  constexpr std::string_view kSpecial = "\\`*_{}[]<>#|~&";
  std::string escaped;
  for (const char c : text) {
    if (kSpecial.find(c) != std::string_view::npos) escaped += '\\';
    escaped += IsControl(c) ? ' ' : c;
  }
  return escaped;
}

std::string EscapeLatex(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
      case '%':
      case '$':
      case '#':
      case '_':
      case '{':
      case '}':
        escaped += '\\';
        escaped += c;
        break;
      case '\\':
        escaped += "\\textbackslash{}";
        break;
      case '~':
        escaped += "\\textasciitilde{}";
        break;
      case '^':
        escaped += "\\textasciicircum{}";
        break;
      case '<':  // other characters in LaTeX's default encoding
        escaped += "\\textless{}";
        break;
      case '>':
        escaped += "\\textgreater{}";
        break;
      case '|':
        escaped += "\\textbar{}";
        break;
      case '"':
        escaped += "\\char34{}";
        break;
      default:
        escaped += IsControl(c) ? ' ' : c;
    }
  }
  return escaped;
}

std::string FormatPlain(const ReportTable& table) {
  terminal::Table plain;
  plain.AddRow(table.columns);
  for (const std::vector<std::string>& row : table.rows) plain.AddRow(row);
  return plain.Format();
}

std::string FormatMarkdown(const std::vector<ReportTable>& tables) {
  std::string text;
  for (const ReportTable& table : tables) {
    if (!text.empty()) text += '\n';
    text += "## " + EscapeMarkdown(table.title) + "\n\n";
    text += "| " + Join(table.columns, " | ", EscapeMarkdown) + " |\n|";
    for (const bool number : NumberColumns(table)) text += number ? "---:|" : "---|";
    text += '\n';
    for (const std::vector<std::string>& row : table.rows) {
      text += "| " + Join(row, " | ", EscapeMarkdown) + " |\n";
    }
  }
  return text;
}

std::string FormatLatex(const std::vector<ReportTable>& tables) {
  // Inside a document LaTeX defines \@nodocument as \relax.
  std::string text =
      "% Compiles as a document; \\input inserts the tables into another one.\n"
      "\\expandafter\\ifx\\csname @nodocument\\endcsname\\relax\\else\n"
      "\\documentclass{article}\n"
      "\\begin{document}\n"
      "\\def\\ceilmapalone{}\n"
      "\\fi\n";
  for (const ReportTable& table : tables) {
    std::string columns;
    for (const bool number : NumberColumns(table)) columns += number ? 'r' : 'l';
    text += "\n\\begin{table}[htbp]\n\\centering\\footnotesize\n\\caption{" +
            EscapeLatex(table.title) + "}\n\\begin{tabular}{" + columns + "}\n\\hline\n" +
            Join(table.columns, " & ", EscapeLatex) + " \\\\\n\\hline\n";
    for (const std::vector<std::string>& row : table.rows) {
      text += Join(row, " & ", EscapeLatex) + " \\\\\n";
    }
    text += "\\hline\n\\end{tabular}\n\\end{table}\n";
  }
  return text + "\n\\ifdefined\\ceilmapalone\\end{document}\\fi\n";
}

}  // namespace ceilmap::reports
