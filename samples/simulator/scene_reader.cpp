#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/yaml_value.hpp"
#include "samples/simulator/scene.hpp"
#include "samples/simulator/scene_fields.hpp"
#include "samples/simulator/scene_values.hpp"
#include "samples/simulator/sessions.hpp"

namespace ceilmap::simulator {
namespace {

constexpr std::string_view kWhat = "a scene file (format: samples/simulator/README.md)";

void ReadCeiling(const YamlValue& value, Ceiling& ceiling) {
  AllowOnly(value, kCeilingFields, "kind", "marks_at", "plain");
  ReadKind(value, kCeilingKinds, ceiling.kind);
  ReadFields(value,
             kCeilingFields,
             ceiling,
             Only(ceiling.kind),
             kCeilingKinds.at(static_cast<std::size_t>(ceiling.kind)));
  ReadRows<4>(value, "marks_at", kMarkColumns, [&](const double* row) {
    ceiling.marks_at.push_back({row[0], row[1], row[2], row[3]});
  });
  ReadFieldRows(value, "plain", kPlainColumns, kPlainFields, ceiling.plain);
}

void ReadFixtures(const YamlValue& value, Fixtures& fixtures) {
  AllowOnly(value, kFixtureFields, "boxes");
  ReadFields(value, kFixtureFields, fixtures);
  ReadRows<8>(value, "boxes", kBoxColumns, [&](const double* row) {
    fixtures.boxes.push_back({row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]});
  });
}

void ReadSteps(const YamlValue& value, std::vector<ExposureStep>& steps) {
  ReadRows<2>(value, "exposure_steps", kStepColumns, [&](const double* row) {
    const auto frame = static_cast<std::int64_t>(std::clamp(row[0], -1.0, 1e9));
    if (static_cast<double>(frame) != row[0]) {
      value.At("exposure_steps", "")
          .Fail("whole frame numbers >= 0", "correct " + fmt::format("{:g}", row[0]));
    }
    steps.push_back({frame, row[1]});
  });
}

void ReadImage(const YamlValue& value, Image& image) {
  AllowOnly(value, kImageFields, "exposure_steps", "dark");
  ReadFields(value, kImageFields, image);
  ReadSteps(value, image.exposure_steps);
  ReadFieldRows(value, "dark", kTimeSpanColumns, kTimeSpanFields, image.dark);
}

void ReadPath(const YamlValue& value, Path& path) {
  AllowOnly(value, kPathFields, "kind", "area_m", "waypoints_m", "tum_file", "carried");
  ReadKind(value, kPathKinds, path.kind);
  const std::string_view kind = kPathKinds.at(static_cast<std::size_t>(path.kind));
  ReadFields(value, kPathFields, path, Only(path.kind), kind);
  const bool is_tum = path.kind == PathKind::kTum;
  const bool is_waypoints = path.kind == PathKind::kWaypoints;
  RefuseUnless(!is_tum && !is_waypoints, value, "area_m", kind);
  RefuseUnless(is_waypoints, value, "waypoints_m", kind);
  RefuseUnless(is_tum, value, "tum_file", kind);
  ReadArray(value, "area_m", path.area_m);
  ReadRows<2>(value, "waypoints_m", kPointColumns, [&](const double* row) {
    path.waypoints_m.push_back({row[0], row[1]});
  });
  ReadFieldRows(value, "carried", kCarriedColumns, kCarriedFields, path.carried);
  if (const auto file = value.Find("tum_file")) {
    path.tum_file = value.File().parent_path() / file->Text();
  }
}

void ReadLens(const YamlValue& value, Camera& camera) {
  if (const auto name = value.Find("distortion_model")) {
    const auto model = calib::FindLensModel(name->Text());
    if (!model) {
      name->Fail("one of plumb_bob, rational_polynomial, equidistant", "correct it");
    }
    camera.distortion_model = *model;
  }
  const auto given = value.Find("distortion");
  if (!given) return;
  const std::vector<double> read =
      given->Numbers(calib::CoefficientNames(camera.distortion_model).size());
  std::copy(read.begin(), read.end(), camera.distortion.begin());
}

void ReadCamera(const YamlValue& value, Camera& camera) {
  AllowOnly(value, kCameraFields, "distortion_model", "distortion", "readout_time_s");
  ReadFields(value, kCameraFields, camera);
  ReadFields(value, kUpFields, camera);
  ReadLens(value, camera);
}

void ReadForward(const YamlValue& value, Camera& camera) {
  AllowOnly(value, kCameraFields, "distortion_model", "distortion", "saturation");
  ReadFields(value, kCameraFields, camera);
  ReadFields(value, kForwardFields, camera);
  ReadLens(value, camera);
}

void ReadOmni(const YamlValue& value, OmniCamera& camera) {
  AllowOnly(value, kOmniFields, "centre_offset_px", "exposure_steps");
  ReadFields(value, kOmniFields, camera);
  ReadArray(value, "centre_offset_px", camera.centre_offset_px);
  ReadSteps(value, camera.exposure_steps);
}

Structure ReadStructure(const std::string& name, const YamlValue& value) {
  AllowOnly(value, kStructureFields, "kind", "along");
  StructureKind kind = StructureKind::kPipe;
  (void)value.At("kind", fmt::format("one of {}", fmt::join(kStructureKinds, ", ")));
  ReadKind(value, kStructureKinds, kind);
  Structure structure = DefaultStructure(kind);
  structure.name = name;
  ReadKind(value, kAxes, structure.along, "along");
  ReadFields(value,
             kStructureFields,
             structure,
             Only(kind),
             kStructureKinds.at(static_cast<std::size_t>(kind)));
  return structure;
}

void ReadWheels(const YamlValue& value, Wheels& wheels) {
  AllowOnly(value, kWheelsFields, "kind", "slips", "gaps");
  ReadKind(value, kWheelsKinds, wheels.kind);
  ReadFields(value, kWheelsFields, wheels);
  ReadFieldRows(value, "slips", kSlipColumns, kSlipFields, wheels.slips);
  ReadFieldRows(value, "gaps", kTimeSpanColumns, kTimeSpanFields, wheels.gaps);
}

void ReadGyro(const YamlValue& value, Gyro& gyro) {
  AllowOnly(value, kGyroFields);
  ReadFields(value, kGyroFields, gyro);
}

void ReadDebris(const YamlValue& value, const Path& path, Debris& debris) {
  AllowOnly(value, kDebrisFields, "bumps");
  if (path.kind == PathKind::kTum) {
    value.Fail("absent for path.kind tum", "remove it, the poses of the file hold the tilt");
  }
  ReadFields(value, kDebrisFields, debris);
  const auto bumps = value.Find("bumps");
  if (!bumps) return;
  ReadFieldRows(value, "bumps", kBumpColumns, kBumpFields, debris.bumps);
}

Scene ReadAll(const YamlValue& root) {
  root.AllowOnly({"seed",
                  "session",
                  "sessions",
                  "robot",
                  "axle_behind_mast_m",
                  "room",
                  "ceiling",
                  "fixtures",
                  "camera",
                  "forward",
                  "omni",
                  "picture",
                  "structures",
                  "movers",
                  "path",
                  "wheels",
                  "gyro",
                  "debris"});
  Scene scene;
  if (const auto seed = root.Find("seed")) {
    scene.seed = static_cast<std::uint64_t>(seed->WholeNumber(0, 2147483647));
  }
  if (const auto robot = root.Find("robot")) scene.robot = robot->Text();
  if (const auto axle = root.Find("axle_behind_mast_m")) {
    scene.axle_behind_mast_m = axle->Number();
  }
  if (const auto room = root.Find("room")) {
    AllowOnly(*room, kRoomFields);
    ReadFields(*room, kRoomFields, scene.room);
  }
  if (const auto ceiling = root.Find("ceiling")) ReadCeiling(*ceiling, scene.ceiling);
  if (const auto fixtures = root.Find("fixtures")) ReadFixtures(*fixtures, scene.fixtures);
  if (const auto camera = root.Find("camera")) ReadCamera(*camera, scene.camera);
  if (const auto forward = root.Find("forward")) {
    ReadForward(*forward, scene.forward.emplace(DefaultForwardCamera()));
  }
  if (const auto omni = root.Find("omni")) ReadOmni(*omni, scene.omni.emplace());
  if (const auto structures = root.Find("structures")) {
    for (const auto& [name, value] : structures->Entries()) {
      scene.structures.push_back(ReadStructure(name, value));
    }
  }
  ReadFieldRows(root, "movers", kMoverColumns, kMoverFields, scene.movers);
  if (const auto image = root.Find("picture")) ReadImage(*image, scene.image);
  if (const auto path = root.Find("path")) ReadPath(*path, scene.path);
  if (const auto wheels = root.Find("wheels")) ReadWheels(*wheels, scene.wheels.emplace());
  if (const auto gyro = root.Find("gyro")) ReadGyro(*gyro, scene.gyro.emplace());
  if (const auto debris = root.Find("debris")) ReadDebris(*debris, scene.path, scene.debris);
  return scene;
}

}  // namespace

Scene ParseScene(const std::string& text,
                 const std::filesystem::path& file,
                 const SceneChoice& choice) {
  const YamlValue root = YamlValue::Parse(text, file, kWhat);
  Scene scene = ReadAll(root);
  if (choice.seed) scene.seed = *choice.seed;
  std::optional<int> session = choice.session;
  const std::optional<Sessions> sessions = ReadSessionsOf(root, scene.path, session);
  try {
    scene.Validate();
    if (!sessions) return scene;
    ApplySession(*sessions, *session, scene);
    scene.Validate();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  return scene;
}

Scene ReadScene(const std::filesystem::path& file) {
  return ParseScene(ReadSettingsText(file, kWhat), file);
}

}  // namespace ceilmap::simulator
