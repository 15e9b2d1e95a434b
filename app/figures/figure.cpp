#include "app/figures/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <thread>
#include <utility>

#include "app/figures/gnuplot.hpp"
#include "app/recordings/ordered_work.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::figures {
namespace {

constexpr std::array<const char*, 3> kFormats = {"svg", "png", "pdf"};

// The same as in samples/experiments.gp.
constexpr std::string_view kHouseStyle = R"(set datafile separator ','
set encoding utf8

# Okabe and Ito's colours, which colour-blind people can distinguish; dashes and points differ as well.
set style line 1 lc rgb '#0072B2' lw 2 dt 1 pt 7 ps 0.5
set style line 2 lc rgb '#D55E00' lw 2 dt (8,3) pt 5 ps 0.5
set style line 3 lc rgb '#E69F00' lw 2 dt (2,3) pt 9 ps 0.5
set style line 4 lc rgb '#009E73' lw 2 dt (8,3,2,3) pt 13 ps 0.5
set style line 5 lc rgb '#000000' lw 1 dt 1                       # truth
set style line 6 lc rgb '#AAAAAA' lw 6 dt 1                       # truth, under other lines
set style line 7 lc rgb '#D55E00' lw 1.5 dt (4,3) pt 6 ps 1       # what is pointed at
set style line 9 lc rgb '#DDDDDD' lw 1 dt 1
set tics nomirror out scale 0.6
set grid ls 9

# All formats show the same figure: a unit of size is a pixel of the SVG, two of the PNG and 1/96 inch of the PDF.
terminal(format, width, height) = format eq 'svg' ? \
  sprintf("set terminal svg size %d,%d background '#FFFFFF' font 'DejaVu Sans,13'", width, height) : \
  format eq 'png' ? \
  sprintf("set terminal pngcairo size %d,%d font 'DejaVu Sans,10' fontscale 2 linewidth 2 pointscale 2", \
    2 * width, 2 * height) : \
  sprintf("set terminal pdfcairo size %gin,%gin font 'DejaVu Sans,10'", width / 96., height / 96.)
)";

}  // namespace

std::string Figure::Script() const {
  return fmt::format(
      "# Draws {0}.svg, {0}.png and {0}.pdf in this folder: gnuplot {0}.gp\n\n{1}\n{2}\n"
      "do for [format in 'svg png pdf'] {{\n"
      "  eval terminal(format, {3}, {4})\n"
      "  set output '{0}.' . format\n"
      "{5}"
      "  set output\n"
      "}}\n",
      name,
      kHouseStyle,
      settings,
      width_px,
      height_px,
      plot);
}

std::string GnuplotQuote(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    const bool control = static_cast<unsigned char>(c) < ' ';
    if (c == '\'') quoted += '\'';
    quoted += control ? ' ' : c;
  }
  return quoted + "'";
}

FigureFolder::FigureFolder(fs::path folder, files::Existing existing) : folder_(std::move(folder)) {
  files::CheckOutputFolder(folder_, existing);
  if (!FindGnuplot()) {
    throw RunError(
        "gnuplot, which draws figures, is not installed; install it by "
        "'samples/install-deps.sh --plots' or 'apt-get install gnuplot-nox'");
  }
}

void FigureFolder::Write(const Figure& figure) {
  for (const Figure::Data& data : figure.data) {
    files::WriteFileAtomically(folder_ / data.name, data.text);
    files_.push_back(folder_ / data.name);
  }
  const fs::path script = folder_ / (figure.name + ".gp");
  files::WriteFileAtomically(script, figure.Script());
  files_.push_back(script);
}

void FigureFolder::Take(const Figure& figure, const GnuplotResult& result) {
  std::vector<fs::path> images;
  images.reserve(kFormats.size());
  for (const char* format : kFormats) {
    images.push_back(folder_ / fmt::format("{}.{}", figure.name, format));
  }
  if (result.exit_code == 0) {
    files_.insert(files_.end(), images.begin(), images.end());
    return;
  }
  std::error_code error;
  for (const fs::path& image : images) fs::remove(image, error);  // incomplete or missing
  throw RunError(fmt::format("{}: gnuplot could not draw it: {}",
                             (folder_ / (figure.name + ".gp")).string(),
                             InOneLine(result.messages)));
}

void FigureFolder::Draw(const std::vector<Figure>& figures) {
  std::error_code error;
  fs::create_directory(folder_, error);
  if (error) {
    throw RunError(fmt::format("{}: cannot be created ({})", folder_.string(), error.message()));
  }
  for (const Figure& figure : figures) Write(figure);
  const std::optional<fs::path> gnuplot = FindGnuplot();
  const auto draw = [&](std::int64_t i) {
    const std::string script = figures[static_cast<std::size_t>(i)].name + ".gp";
    return gnuplot ? RunGnuplot(*gnuplot, folder_, script) : GnuplotResult{-1, "it is gone"};
  };
  const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  recordings::OrderedWork<GnuplotResult> work(
      static_cast<std::int64_t>(figures.size()), threads, draw);
  for (const Figure& figure : figures) Take(figure, *work.Next());
}

}  // namespace ceilmap::figures
