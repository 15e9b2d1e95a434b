#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/figures/gnuplot.hpp"

namespace ceilmap::figures {

/// A figure that gnuplot draws. Script and data stay beside the images, so that a figure can be
/// changed and drawn again: `cd FOLDER && gnuplot NAME.gp`.
struct Figure {
  struct Data {
    std::string name;  ///< of the file, e.g. "heading.csv"; comma-separated with a header line
    std::string text;
  };
  std::string name;  ///< becomes NAME.gp, NAME.svg, NAME.png and NAME.pdf
  int width_px = 860;
  int height_px = 420;
  /// What stands before all formats: settings, without the house style that every figure has (line
  /// styles 1 .. 4 for curves, 5 and 6 for the truth over and under them, 7 for what is pointed
  /// at).
  std::string settings;
  /// Draws one format; run once for each of them.
  std::string plot;
  std::vector<Data> data;

  /// The whole of NAME.gp.
  [[nodiscard]] std::string Script() const;
};

/// A text as a string of gnuplot, whatever characters it has; shown as it is (no enhanced text).
std::string GnuplotQuote(std::string_view text);

/// A folder of figures. What else is in it stays.
class FigureFolder {
 public:
  /// Tells before the work that figures could not be drawn. Makes nothing yet.
  /// @throws InputError when the folder cannot be made or written to; RunError when
  ///   gnuplot is not installed.
  explicit FigureFolder(std::filesystem::path folder);

  /// Writes script and data and has the figure drawn, over what has the same name.
  /// @throws RunError when gnuplot fails (its own words, and where the script is) or the
  /// disk
  ///   refuses.
  void Draw(const Figure& figure) { Draw(std::vector<Figure>{figure}); }
  /// The same, with as many gnuplots at a time as there are cores. All scripts and data are there
  /// before the first of them begins: figures may share data.
  void Draw(const std::vector<Figure>& figures);

  /// All that was written.
  [[nodiscard]] const std::vector<std::filesystem::path>& Files() const { return files_; }

 private:
  void Write(const Figure& figure);
  void Take(const Figure& figure, const GnuplotResult& result);

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace ceilmap::figures
