#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/figures/gnuplot.hpp"
#include "app/files/output_files.hpp"

namespace ceilmap::figures {

/// A figure that gnuplot draws. Script and data are kept beside the images, so that a figure can be
/// changed and drawn again: `cd FOLDER && gnuplot NAME.gp`.
struct Figure {
  struct Data {
    std::string name;  ///< file name, e.g. "heading.csv"; comma-separated with a header line
    std::string text;
  };
  std::string name;  ///< for NAME.gp, NAME.svg, NAME.png and NAME.pdf
  int width_px = 860;
  int height_px = 420;
  /// Settings for all formats, in addition to the common style (line styles 1 .. 4 for curves, 5
  /// and 6 for the truth over and below them, 7 for marks).
  std::string settings;
  /// Commands that draw one format; run once for each.
  std::string plot;
  std::vector<Data> data;

  /// The text of NAME.gp.
  [[nodiscard]] std::string Script() const;
};

/// A text as a string of gnuplot, shown without interpretation (no enhanced text).
std::string GnuplotQuote(std::string_view text);

/// A folder of figures. Other files in it are kept.
class FigureFolder {
 public:
  /// Checks before the work that figures can be drawn. Creates no files.
  /// @param existing  Whether files of a folder that is not empty may be replaced.
  /// @throws InputError when the folder cannot be created or written, or must not be used; RunError
  /// when gnuplot is not installed.
  explicit FigureFolder(std::filesystem::path folder,
                        files::Existing existing = files::Existing::kReplace);

  /// Writes script and data and draws the figure; replaces files of the same name.
  /// @throws RunError when gnuplot fails (with its message and the path of the script) or the disk
  /// cannot be written.
  void Draw(const Figure& figure) { Draw(std::vector<Figure>{figure}); }
  /// The same for several figures, with one gnuplot per core. All scripts and data are written
  /// before the first one starts, because figures may share data.
  void Draw(const std::vector<Figure>& figures);

  /// All written files.
  [[nodiscard]] const std::vector<std::filesystem::path>& Files() const { return files_; }

 private:
  void Write(const Figure& figure);
  void Take(const Figure& figure, const GnuplotResult& result);

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace ceilmap::figures
