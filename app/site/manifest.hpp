#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Many recordings, one map: a manifest, the jobs that it needs, and their run.
namespace ceilmap::site {

/// A recording of a manifest. Paths are as written there, relative to the manifest's folder; empty:
/// not given.
struct Recording {
  std::string name;  ///< unique; of letters, digits, '.', '_' and '-': it becomes a file name
  std::string rig;
  std::string up;  ///< SOURCE of `map --up`
  std::string stamps;
  std::string odometry;
  std::string gyro;
  std::string forward;
  int priority = 0;                  ///< higher: made first; the highest has the frame of the site
  std::vector<std::string> options;  ///< more options of `map`
};

/// A map that exists already and takes part, with priority 0.
struct ExistingMap {
  std::string name;  ///< of its file, unique as the names of recordings
  std::string file;
};

/// Options for all jobs of one command.
struct StepOptions {
  std::vector<std::string> map;
  std::vector<std::string> match;
  std::vector<std::string> solve;
  std::vector<std::string> align;
  /// Jobs that draw the mosaic; 1: the solution draws it. 0: not given.
  int mosaic_parts = 0;
};

/// A manifest, SITE.yaml. Paths as those of a recording.
struct Manifest {
  std::filesystem::path folder;  ///< of the manifest, absolute
  std::string output;            ///< the map of the site, NAME.gpkg
  std::string work;              ///< folder of maps, matches, logs; default: NAME.work
  std::vector<Recording> recordings;
  std::vector<ExistingMap> maps;
  StepOptions options;
  std::string
      control_points;  ///< points.csv of `align`; empty: the map keeps the frame of a recording
  std::string crs;     ///< of the points, EPSG:n
};

/// Reads a manifest strictly. No text of it holds a control character or line break, names are safe
/// as file names, options change neither the results' names nor what the manifest's keys state, and
/// all files that it names exist.
/// @throws InputError FILE:LINE: KEY = VALUE, must be ...; FIX
Manifest ReadManifest(const std::filesystem::path& file);

/// The same from the text of a manifest. @param file  For messages, and for the folder.
Manifest ParseManifest(const std::string& text, const std::filesystem::path& file);

}  // namespace ceilmap::site
