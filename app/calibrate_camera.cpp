#include <memory>
#include <string>
#include <vector>

#include "app/calibrate_commands.hpp"
#include "app/output_files.hpp"
#include "calib/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

struct CalibrateCameraParams {
  std::vector<std::string> pictures;
  fs::path output;
};

void RunCalibrateCamera(const CalibrateCameraParams& params,
                        const CommonOptions& /*common*/,
                        Summary& /*summary*/) {
  CheckOutputFiles({params.output});
  throw calib::RunError("calibrate camera: is not there yet");
}

}  // namespace

Command AddCalibrateCameraCommand(CLI::App& calibrate) {
  Command command =
      MakeCommand(calibrate,
                  "camera",
                  "Measures a camera's focal lengths, centre and distortion with a printed board.",
                  "ceilmap calibrate camera pictures --corners 9x6 --square 0.025 -o up.yaml");
  auto params = std::make_shared<CalibrateCameraParams>();
  command.cli
      ->add_option(
          "pictures", params->pictures, "A folder of pictures, a video, or several pictures")
      ->type_name("SOURCE");
  command.cli->add_option("-o,--output", params->output, "ROS camera_info of the camera")
      ->type_name("INFO.yaml");
  command.run = [params](const CommonOptions& common, Summary& summary) {
    RunCalibrateCamera(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::app
