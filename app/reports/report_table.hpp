#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::reports {

/// A table of results, for terminals, READMEs and papers.
struct ReportTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`
};

/// In the format of Table, without the title.
std::string FormatPlain(const ReportTable& table);

/// All tables, each with its title; columns of numbers are right-aligned.
std::string FormatMarkdown(const std::vector<ReportTable>& tables);

/// The same in plain LaTeX, without packages: a document that compiles alone; \input inserts only
/// the tables into another document.
std::string FormatLatex(const std::vector<ReportTable>& tables);

/// Escapes the special characters of Markdown, or of LaTeX; line breaks become blanks.
std::string EscapeMarkdown(std::string_view text);
std::string EscapeLatex(std::string_view text);

}  // namespace ceilmap::reports
