#include "app/reports/report_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ceilmap::reports {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const ReportTable kTable{"Errors, 50 %",
                         {"estimate", "rmse_m"},
                         {{"run_1", "0.25"}, {"a|b", ""}, {"half & half", "-1.5"}}};

TEST(ReportTable, Plain) {
  EXPECT_EQ(FormatPlain(kTable),
            "estimate     rmse_m\n"
            "run_1          0.25\n"
            "a|b\n"
            "half & half    -1.5\n");
}

TEST(ReportTable, Markdown) {
  EXPECT_EQ(FormatMarkdown({kTable, {"B", {"x"}, {{"word"}}}}),
            "## Errors, 50 %\n\n"
            "| estimate | rmse\\_m |\n"
            "|---|---:|\n"
            "| run\\_1 | 0.25 |\n"
            "| a\\|b |  |\n"
            "| half \\& half | -1.5 |\n"
            "\n## B\n\n| x |\n|---|\n| word |\n");
}

TEST(ReportTable, Latex) {
  const std::string text = FormatLatex({kTable});
  EXPECT_THAT(text, StartsWith("% Compiles as a document"));
  EXPECT_THAT(text,
              HasSubstr("\\caption{Errors, 50 \\%}\n"
                        "\\begin{tabular}{lr}\n"
                        "\\hline\n"
                        "estimate & rmse\\_m \\\\\n"
                        "\\hline\n"
                        "run\\_1 & 0.25 \\\\\n"
                        "a\\textbar{}b &  \\\\\n"
                        "half \\& half & -1.5 \\\\\n"
                        "\\hline\n"
                        "\\end{tabular}\n"));
}

TEST(ReportTable, NothingInANameMeansAnything) {
  EXPECT_EQ(EscapeLatex("a_b&c%$#{}~^\\<>|\"\nd"),
            "a\\_b\\&c\\%\\$\\#\\{\\}\\textasciitilde{}\\textasciicircum{}\\textbackslash{}"
            "\\textless{}\\textgreater{}\\textbar{}\\char34{} d");
  EXPECT_EQ(EscapeMarkdown("*a*_b_[c](d)<e>`f`|\ng\\"),
            "\\*a\\*\\_b\\_\\[c\\](d)\\<e\\>\\`f\\`\\| g\\\\");
}

}  // namespace
}  // namespace ceilmap::reports
