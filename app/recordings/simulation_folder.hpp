#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/files/output_files.hpp"
#include "app/recordings/recording_writer.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::recordings {

/// The folder of a simulated recording: for each camera `up.mp4`, `forward.mp4`, `omni.mp4` (or
/// `up.mkv`, or the images `up/`), and `frames.csv`, `truth.tum`, `rig.yaml`, `scene.yaml`, and
/// `points.csv` if there are known points; `odometry.csv`, `gyro.csv` and `wheels.yaml` if the
/// robot has wheels and gyro, `changes.csv` and `disturbances.csv` if the scene has sessions. Other
/// files in it are not changed.
class SimulationFolder {
 public:
  /// The images of one camera, `up`, `forward` or `omni`.
  struct Recording {
    std::string camera;
    std::unique_ptr<RecordingWriter> writer;
  };
  /// A file whose text is empty is not in the recording.
  struct Texts {
    std::string stamps;
    std::string truth;
    std::string rig;
    std::string scene;
    std::string points;
    std::string odometry;
    std::string gyro;
    std::string sensor_truth;  ///< wheels.yaml
    std::string changes;
    std::string disturbances;
  };

  /// Creates the folder if it is missing; without Commit() the destructor removes it again.
  /// @param existing  Whether Commit() may replace an earlier recording in the folder.
  /// @throws InputError when the folder cannot be created or written, or contains a recording that
  /// must not be replaced.
  SimulationFolder(std::filesystem::path folder, RecordingFormat format, files::Existing existing);
  ~SimulationFolder();
  SimulationFolder(const SimulationFolder&) = delete;
  SimulationFolder& operator=(const SimulationFolder&) = delete;

  /// Target of a camera's images.
  [[nodiscard]] std::filesystem::path ImagesOf(std::string_view camera) const;

  /// Gives all files their names. Files of an earlier run that are not in this one are removed,
  /// because the new stamps are not theirs. @param recordings  Each writes ImagesOf() its camera.
  /// @return the files. @throws RunError when the disk cannot be written.
  std::vector<std::filesystem::path> Commit(const std::vector<Recording>& recordings,
                                            const Texts& texts);

 private:
  void RefuseEarlier(files::Existing existing) const;

  std::filesystem::path folder_;
  RecordingFormat format_;
  bool made_ = false;  // by this object, and not yet committed
};

/// A scene's text with the seed and the session of `scene`, so that it gives the same recording
/// without options.
/// @param file  The scene's, for messages.
std::string TextOf(const std::string& text,
                   const std::filesystem::path& file,
                   const simulator::Scene& scene);

}  // namespace ceilmap::recordings
