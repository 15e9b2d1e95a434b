#include "app/manual/man_pages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "tests/app/manual/sample_program.hpp"

namespace ceilmap::manual {
namespace {

using testing::HasSubstr;

TEST(ManPages, ThereIsOneOfEachCommand) {
  const SampleProgram sample;
  std::vector<std::string> names;
  for (const auto& [name, page] : ManPages(sample.app, "tool 1")) names.push_back(name);
  EXPECT_THAT(
      names,
      testing::ElementsAre("tool", "tool-draw", "tool-help", "tool-store", "tool-store-put"));
}

TEST(ManPages, APageHasAllThatHelpSays) {
  const SampleProgram sample;
  EXPECT_EQ(ManPages(sample.app, "tool 1.2").at("tool-draw"),
            R"(.TH TOOL\-DRAW 1 "" "tool 1.2" "User Commands"
.nh
.ad l
.SH NAME
tool\-draw \- draws a map\(aqs parts
.SH SYNOPSIS
\fBtool draw\fR \fB\-\-output\fR \fIFILE.pdf|svg\fR [\fIOPTIONS\fR] \fImap\fR
.SH DESCRIPTION
Draws a map\(aqs parts. Slowly.
.SH ARGUMENTS
.TP
\fImap\fR \fIMAP.gpkg\fR
The map.
Required.
.SH OPTIONS
.TP
\fB\-h\fR, \fB\-\-help\fR
Print this help message and exit
.TP
\fB\-o\fR, \fB\-\-output\fR \fIFILE.pdf|svg\fR
The result.
Required.
.TP
\fB\-\-format\fR \fITEXT\fR
Format.
One of ros, png.
.TP
\fB\-\-folder\fR \fIDIR\fR
A folder.
.TP
\fB\-\-up\fR \fISOURCE\fR
A video
.TP
\fB\-\-count\fR \fIN\fR
How many.
From 2 to 64.
.SS Common
.TP
\fB\-\-quiet\fR
Print less.
Not together with \fB\-\-verbose\fR.
.TP
\fB\-\-verbose\fR
Print more.
Not together with \fB\-\-quiet\fR.
.SH EXAMPLES
.EX
tool draw a.gpkg \-o \(aqb.pdf\(aq
.EE
.SH NOTES
\&.hidden files are not read.
.SH EXIT STATUS
.TP
0
The command is done.
.TP
1
The run failed.
.TP
2
Arguments or input files cannot be used.
.SH SEE ALSO
\fBtool\fR(1)
)");
}

TEST(ManPages, ThePageOfACommandWithCommandsListsThem) {
  const SampleProgram sample;
  const std::string page = ManPages(sample.app, "tool 1").at("tool-store");
  EXPECT_THAT(page, HasSubstr(".SH SYNOPSIS\n\\fBtool store\\fR \\fICOMMAND\\fR"));
  EXPECT_THAT(page, HasSubstr(".SH COMMANDS\n.TP\n\\fBput\\fR\nAdds maps.\n"));
  EXPECT_THAT(page, HasSubstr("\\fBtool\\fR(1),\n\\fBtool\\-store\\-put\\fR(1)\n"));
}

}  // namespace
}  // namespace ceilmap::manual
