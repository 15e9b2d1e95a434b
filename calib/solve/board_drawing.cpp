#include "calib/solve/board_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::calibration {
namespace {

constexpr double kRulerMm = 100;
constexpr double kTickMm = 10;
constexpr double kTextMm = 3.2;  // size of letters
constexpr double kFootMm = 12;   // for ruler and text
constexpr double kMarginMm = 6;  // unprintable margin, and white around the board
constexpr double kLineMm = 0.2;

using Rectangle = BoardDrawing::Rectangle;

// The white cells of a marker, joined by rows.
void AddMarker(
    const cv::Mat1b& cells, double x_mm, double y_mm, double side_mm, std::vector<Rectangle>& to) {
  const double cell_mm = side_mm / cells.cols;
  to.push_back({x_mm, y_mm, side_mm, side_mm});
  for (int row = 0; row < cells.rows; ++row) {
    for (int first = 0; first < cells.cols;) {
      int end = first;
      while (end < cells.cols && cells(row, end) > 0) ++end;
      if (end > first) {
        to.push_back(
            {x_mm + first * cell_mm, y_mm + row * cell_mm, (end - first) * cell_mm, cell_mm, true});
      }
      first = end + 1;
    }
  }
}

// Squares by rows from the top; white squares of a ChArUco board get their markers in that order.
void AddSquares(const Board& board, double left_mm, double top_mm, std::vector<Rectangle>& to) {
  const bool charuco = board.kind == BoardKind::kCharuco;
  const double square_mm = 1e3 * board.square_m;
  const double marker_mm = 1e3 * board.marker_m;
  const double inset_mm = (square_mm - marker_mm) / 2;
  int id = 0;
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      const double x_mm = left_mm + column * square_mm;
      const double y_mm = top_mm + row * square_mm;
      if ((row + column) % 2 == 0) {
        to.push_back({x_mm, y_mm, square_mm, square_mm});
      } else if (charuco) {
        AddMarker(
            MarkerCells(board.dictionary, id++), x_mm + inset_mm, y_mm + inset_mm, marker_mm, to);
      }
    }
  }
}

std::string Describe(const Board& board) {
  std::string text = fmt::format("{}, squares {:g} mm", board.Name(), 1e3 * board.square_m);
  if (board.kind == BoardKind::kCharuco) {
    text += fmt::format(", markers {:g} mm of {}", 1e3 * board.marker_m, board.dictionary);
  }
  return text + "; print at 100 %: the ruler is 100 mm long";
}

// The ruler as rectangles: a line, and ticks with increasing length at both ends.
std::vector<Rectangle> Ruler(const BoardDrawing& drawing) {
  std::vector<Rectangle> lines = {
      {drawing.ruler_x_mm, drawing.ruler_y_mm - kLineMm / 2, kRulerMm, kLineMm}};
  const int ticks = static_cast<int>(kRulerMm / kTickMm);
  for (int i = 0; i <= ticks; ++i) {
    const double length_mm = i % ticks == 0 ? 4 : 2;
    lines.push_back({drawing.ruler_x_mm + i * kTickMm - kLineMm / 2,
                     drawing.ruler_y_mm - length_mm,
                     kLineMm,
                     length_mm});
  }
  return lines;
}

std::vector<Rectangle> AllRectangles(const BoardDrawing& drawing) {
  std::vector<Rectangle> all = drawing.rectangles;
  const std::vector<Rectangle> ruler = Ruler(drawing);
  all.insert(all.end(), ruler.begin(), ruler.end());
  return all;
}

// Offsets of objects, for the table at the end of a PDF file.
class PdfWriter {
 public:
  void AddObject(const std::string& body) {
    offsets_.push_back(text_.size());
    text_ += fmt::format("{} 0 obj\n{}\nendobj\n", offsets_.size(), body);
  }
  std::string Finish() {
    const std::size_t start = text_.size();
    text_ += fmt::format("xref\n0 {}\n0000000000 65535 f \n", offsets_.size() + 1);
    for (const std::size_t offset : offsets_) text_ += fmt::format("{:010} 00000 n \n", offset);
    text_ += fmt::format(
        "trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n", offsets_.size() + 1, start);
    return std::move(text_);
  }

 private:
  std::string text_ = "%PDF-1.4\n";
  std::vector<std::size_t> offsets_;
};

}  // namespace

Paper ParsePaper(const std::string& name) {
  static const std::array<Paper, 3> kPapers = {
      {{"a4", 210, 297}, {"a3", 297, 420}, {"letter", 215.9, 279.4}}};
  const auto* const found = std::find_if(
      kPapers.begin(), kPapers.end(), [&](const Paper& paper) { return paper.name == name; });
  if (found != kPapers.end()) return *found;
  throw InputError(fmt::format("paper {}: must be a4, a3 or letter", name));
}

BoardDrawing DrawBoard(const Board& board, const Paper& paper) {
  board.Validate();
  const double board_width_mm = 1e3 * board.square_m * (board.columns + 1);
  const double board_height_mm = 1e3 * board.square_m * (board.rows + 1);
  BoardDrawing drawing;
  const bool wide = board_width_mm > board_height_mm;
  drawing.width_mm = wide ? paper.height_mm : paper.width_mm;
  drawing.height_mm = wide ? paper.width_mm : paper.height_mm;
  const double room_mm = drawing.height_mm - kFootMm;
  if (board_width_mm + 2 * kMarginMm > drawing.width_mm ||
      board_height_mm + 2 * kMarginMm > room_mm) {
    const double fitting_mm = std::min((drawing.width_mm - 2 * kMarginMm) / (board.columns + 1),
                                       (room_mm - 2 * kMarginMm) / (board.rows + 1));
    throw InputError(fmt::format(
        "square {:g}: the board of {:.0f} x {:.0f} mm does not fit on {}; take squares of at most "
        "{:.4f} m, or larger paper",
        board.square_m,
        board_width_mm,
        board_height_mm,
        paper.name,
        1e-3 * std::floor(2 * fitting_mm) / 2));
  }
  AddSquares(board,
             (drawing.width_mm - board_width_mm) / 2,
             (room_mm - board_height_mm) / 2,
             drawing.rectangles);
  drawing.ruler_x_mm = kMarginMm + 2;
  drawing.ruler_y_mm = drawing.height_mm - kMarginMm;
  drawing.text = Describe(board);
  return drawing;
}

std::string FormatSvg(const BoardDrawing& drawing) {
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}mm\" height=\"{1:g}mm\" "
      "viewBox=\"0 0 {0:g} {1:g}\" shape-rendering=\"crispEdges\">\n"
      "<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"white\"/>\n",
      drawing.width_mm,
      drawing.height_mm);
  for (const Rectangle& r : AllRectangles(drawing)) {
    text += fmt::format("<rect x=\"{:.4f}\" y=\"{:.4f}\" width=\"{:.4f}\" height=\"{:.4f}\"{}/>\n",
                        r.x_mm,
                        r.y_mm,
                        r.width_mm,
                        r.height_mm,
                        r.white ? " fill=\"white\"" : "");
  }
  return text +
         fmt::format(
             "<text x=\"{:.2f}\" y=\"{:.2f}\" font-family=\"sans-serif\" font-size=\"{:g}\">{}"
             "</text>\n</svg>\n",
             drawing.ruler_x_mm + kRulerMm + 4,
             drawing.ruler_y_mm,
             kTextMm,
             drawing.text);
}

std::string FormatPdf(const BoardDrawing& drawing) {
  constexpr double kPointsPerMm = 72 / 25.4;
  const auto y_up = [&](double y_mm) { return drawing.height_mm - y_mm; };
  std::string page = fmt::format("{0:.6f} 0 0 {0:.6f} 0 0 cm\n0 g\n", kPointsPerMm);
  bool white = false;
  for (const Rectangle& r : AllRectangles(drawing)) {
    if (r.white != white) page += r.white ? "1 g\n" : "0 g\n";
    white = r.white;
    page += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re f\n",
                        r.x_mm,
                        y_up(r.y_mm + r.height_mm),
                        r.width_mm,
                        r.height_mm);
  }
  page += fmt::format("{}BT /F1 {:g} Tf {:.3f} {:.3f} Td ({}) Tj ET",
                      white ? "0 g\n" : "",
                      kTextMm,
                      drawing.ruler_x_mm + kRulerMm + 4,
                      y_up(drawing.ruler_y_mm),
                      drawing.text);
  PdfWriter pdf;
  pdf.AddObject("<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>");
  pdf.AddObject("<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
  pdf.AddObject(
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.3f} {:.3f}] /Contents 4 0 R "
                  "/Resources << /Font << /F1 5 0 R >> >> >>",
                  drawing.width_mm * kPointsPerMm,
                  drawing.height_mm * kPointsPerMm));
  pdf.AddObject(fmt::format("<< /Length {} >>\nstream\n{}\nendstream", page.size() + 1, page));
  pdf.AddObject("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
  return pdf.Finish();
}

}  // namespace ceilmap::calibration
