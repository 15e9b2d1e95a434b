#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::reports {

/// A table of results, for a terminal, a README and a paper alike.
struct ReportTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`
};

/// As Table prints it, without the title.
std::string FormatPlain(const ReportTable& table);

/// One after the other, each under its title; columns of numbers stand to the right.
std::string FormatMarkdown(const std::vector<ReportTable>& tables);

/// The same in plain LaTeX, without packages: a document that compiles as it is, and that a paper
/// takes in with \input as well, tables only.
std::string FormatLatex(const std::vector<ReportTable>& tables);

/// Text with every character escaped that would mean something in Markdown, or in LaTeX; line
/// breaks become blanks.
std::string EscapeMarkdown(std::string_view text);
std::string EscapeLatex(std::string_view text);

}  // namespace ceilmap::reports
