#include "app/commands/wheel_options.hpp"

#include "app/files/output_files.hpp"
#include "app/recordings/sensor_inputs.hpp"
#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "calib/rig_text.hpp"

namespace ceilmap::commands {

void WheelOptions::AddTo(CLI::App& cli,
                         const std::string& inputs,
                         const std::string& results,
                         const std::string& gyro_text) {
  const auto add = [&cli](
                       const char* name, auto& value, const std::string& text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("--odometry",
      odometry,
      "Wheel odometry: TUM, or CSV timestamp,x,y,yaw_deg or timestamp,v,omega, or a bag",
      "WHEELS")
      ->group(inputs);
  add("--gyro", gyro, gyro_text, "GYRO.csv")->group(inputs);
  add("--rig-out", rig_out, "The rig with the constants found of wheels and gyro", "RIG.yaml")
      ->group(results);
}

void WheelOptions::TakeBag(const recordings::BagOptions& bags,
                           const std::string& main_option,
                           const std::string& main) {
  odometry = bags.Complete("odometry", odometry.string(), main_option, main);
  gyro = bags.Complete("gyro", gyro.string(), main_option, main);
}

void WheelOptions::Reserve(const recordings::BagOptions& bags) const {
  recordings::SensorFiles files;
  files.odometry = odometry;
  files.gyro = gyro;
  files.odometry_topic = bags.Topic("odometry");
  files.gyro_topic = bags.Topic("gyro");
  recordings::ReserveTopics(files);
}

void WheelOptions::CheckRigOut(bool have_rig) const {
  if (rig_out.empty()) return;
  if (!Given()) {
    throw InputError(
        "--rig-out: states what is found of wheels and gyro; give --odometry or --gyro");
  }
  if (!have_rig) throw InputError("--rig-out: completes the rig of the run; give --rig");
}

void WheelOptions::WriteRig(const calib::Rig& rig,
                            const wheels::WheelsReport& wheels,
                            terminal::Summary& summary) const {
  if (rig_out.empty()) return;
  calib::RigValues values;
  values.wheels = wheels.model;
  AtomicFile file(rig_out);
  files::WriteText(file, calib::ChangeRig(rig.source_yaml, rig.file, values, rig_out));
  file.Commit();
  summary.files.push_back(rig_out);
}

}  // namespace ceilmap::commands
