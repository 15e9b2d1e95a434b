#include "calib/solve/board_drawing.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <regex>

#include "calib/base/error.hpp"

namespace ceilmap::calibration {
namespace {

using testing::HasSubstr;

Board BoardOfKind(BoardKind kind) {
  Board board;
  board.kind = kind;
  board.square_m = 0.025;
  board.marker_m = 0.018;
  return board;
}

TEST(BoardDrawing, DrawsSquaresToScale) {
  const BoardDrawing drawing = DrawBoard(BoardOfKind(BoardKind::kChessboard), ParsePaper("a4"));
  EXPECT_EQ(drawing.width_mm, 297);
  EXPECT_EQ(drawing.height_mm, 210);
  ASSERT_EQ(drawing.rectangles.size(), 35U);  // of 10 x 7 squares every other one
  const auto& first = drawing.rectangles.front();
  EXPECT_DOUBLE_EQ(first.x_mm, 23.5);
  EXPECT_DOUBLE_EQ(first.width_mm, 25);
  EXPECT_DOUBLE_EQ(first.height_mm, 25);
  EXPECT_DOUBLE_EQ(drawing.rectangles[1].x_mm - first.x_mm, 50);
  EXPECT_DOUBLE_EQ(drawing.rectangles[5].x_mm, first.x_mm + 25);  // the second row
}

TEST(BoardDrawing, SvgIsInMillimetres) {
  const std::string svg =
      FormatSvg(DrawBoard(BoardOfKind(BoardKind::kChessboard), ParsePaper("a4")));
  EXPECT_THAT(svg, HasSubstr("width=\"297mm\" height=\"210mm\" viewBox=\"0 0 297 210\""));
  EXPECT_THAT(svg, HasSubstr("x=\"23.5000\""));
  EXPECT_THAT(svg, HasSubstr("width=\"100.0000\""));  // the ruler
  EXPECT_THAT(svg, HasSubstr("chessboard of 9x6 corners, squares 25 mm; print at 100 %"));
}

TEST(BoardDrawing, PdfIsWhatReadersExpect) {
  const std::string pdf = FormatPdf(DrawBoard(BoardOfKind(BoardKind::kCharuco), ParsePaper("a4")));
  EXPECT_TRUE(pdf.starts_with("%PDF-1.4\n"));
  EXPECT_TRUE(pdf.ends_with("%%EOF\n"));
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [0 0 841.890 595.276]"));  // A4 in points
  std::smatch match;
  ASSERT_TRUE(std::regex_search(pdf, match, std::regex("startxref\n([0-9]+)\n")));
  const auto start = static_cast<std::size_t>(std::stoul(match[1]));
  EXPECT_EQ(pdf.substr(start, 5), "xref\n");
  const std::string table = pdf.substr(start);
  const std::regex entry("([0-9]{10}) 00000 n ");
  int object = 0;
  for (auto i = std::sregex_iterator(table.begin(), table.end(), entry);
       i != std::sregex_iterator();
       ++i) {
    const auto at = static_cast<std::size_t>(std::stoul((*i)[1]));
    EXPECT_TRUE(pdf.substr(at).starts_with(std::to_string(++object) + " 0 obj\n"));
  }
  EXPECT_EQ(object, 5);
  ASSERT_TRUE(std::regex_search(pdf, match, std::regex("/Length ([0-9]+) >>\nstream\n")));
  const auto body = static_cast<std::size_t>(match.position() + match.length());
  EXPECT_EQ(pdf.substr(body + std::stoul(match[1]), 10), "endstream\n");
}

TEST(BoardDrawing, TheMessageForALargeBoardNamesTheMaximum) {
  Board board = BoardOfKind(BoardKind::kChessboard);
  board.square_m = 0.03;
  try {
    DrawBoard(board, ParsePaper("a4"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "square 0.03: the board of 300 x 210 mm does not fit on a4; take squares of at most 0.0265 "
        "m, or larger paper");
  }
  board.square_m = 0.0265;
  EXPECT_NO_THROW(DrawBoard(board, ParsePaper("a4")));
}

}  // namespace
}  // namespace ceilmap::calibration
