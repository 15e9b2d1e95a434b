#include "samples/simulator/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "calib/base/error.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/scene_fields.hpp"
#include "samples/simulator/structures.hpp"

namespace ceilmap::simulator {
namespace {

[[noreturn]] void Fail(const std::string& key, double value, const std::string& must_be) {
  throw InputError(fmt::format("{} = {:g}, must be {}", key, value, must_be));
}

void CheckRange(const std::string& key, double value, double least, double most) {
  if (!(value >= least && value <= most)) Fail(key, value, RangeText(least, most));
}

template <typename Group, std::size_t N>
void CheckGroup(const char* name, const Group& group, const std::array<Field<Group>, N>& fields) {
  for (const Field<Group>& field : fields) {
    std::visit(
        [&](auto member) {
          if constexpr (!std::is_same_v<decltype(member), bool Group::*>) {
            CheckRange(
                fmt::format("{}.{}", name, field.key), group.*member, field.least, field.most);
          }
        },
        field.member);
  }
}

void CheckCamera(const char* name, const Camera& camera, const Room& room) {
  CheckGroup(name, camera, kCameraFields);
  for (const double coefficient : camera.distortion) {
    CheckRange(fmt::format("{}.distortion", name), coefficient, -10, 10);
  }
  if (!(camera.mount_height_m < room.height_m)) {
    Fail(fmt::format("{}.mount_height_m", name),
         camera.mount_height_m,
         "below the ceiling (room.height_m)");
  }
}

void CheckForward(const Scene& scene) {
  if (!scene.forward) return;
  CheckCamera("forward", *scene.forward, scene.room);
  CheckGroup("forward", *scene.forward, kForwardFields);
  CheckRange("forward.readout_time_s", scene.forward->readout_time_s, 0, 0);
  if (!(scene.forward->mount_height_m > 0)) {
    Fail("forward.mount_height_m", scene.forward->mount_height_m, "above the floor");
  }
}

void CheckDebris(const Scene& scene) {
  const std::vector<Bump>& bumps = scene.debris.bumps;
  CheckGroup("debris", scene.debris, kDebrisFields);
  for (std::size_t i = 0; i < bumps.size(); ++i) {
    CheckGroup(fmt::format("debris.bumps[{}]", i).c_str(), bumps[i], kBumpFields);
  }
  if ((!bumps.empty() || scene.debris.uneven_deg > 0) && scene.path.kind == PathKind::kTum) {
    throw InputError("debris must be absent for path.kind tum, whose poses hold the tilt");
  }
  const double length_m = bumps.empty() ? 0 : PathLength(scene);
  for (std::size_t i = 0; i < bumps.size(); ++i) {
    if (bumps[i].start_m < length_m) continue;
    Fail(fmt::format("debris.bumps[{}].start_m", i),
         bumps[i].start_m,
         fmt::format("less than the {:.3f} m of the path", length_m));
  }
}

void CheckMarks(const Scene& scene) {
  for (std::size_t i = 0; i < scene.ceiling.marks_at.size(); ++i) {
    const Mark& mark = scene.ceiling.marks_at[i];
    const std::string name = fmt::format("ceiling.marks_at[{}].", i);
    CheckRange(name + "x_m", mark.x_m, 0, scene.room.length_m);
    CheckRange(name + "y_m", mark.y_m, 0, scene.room.width_m);
    CheckRange(name + "radius_m", mark.radius_m, 1e-4, 100);
    CheckRange(name + "brightness", mark.brightness, 0, 7);
  }
}

void CheckBoxes(const Scene& scene) {
  for (std::size_t i = 0; i < scene.fixtures.boxes.size(); ++i) {
    const Box& box = scene.fixtures.boxes[i];
    const std::string name = fmt::format("fixtures.boxes[{}].", i);
    CheckRange(name + "x_m", box.x_m, -1e4, 1e4);
    CheckRange(name + "y_m", box.y_m, -1e4, 1e4);
    CheckRange(name + "length_m", box.length_m, 1e-3, 1e4);
    CheckRange(name + "width_m", box.width_m, 1e-3, 1e4);
    CheckRange(name + "bottom_m", box.bottom_m, 0, scene.room.height_m);
    if (!(box.top_m > box.bottom_m && box.top_m <= scene.room.height_m)) {
      Fail(name + "top_m", box.top_m, "above bottom_m and not above the ceiling");
    }
    CheckRange(name + "yaw_deg", box.yaw_deg, -360, 360);
    CheckRange(name + "brightness", box.brightness, 0, 7);
  }
}

void CheckSteps(const char* group, const std::vector<ExposureStep>& steps) {
  std::int64_t previous = -1;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const ExposureStep& step = steps[i];
    const std::string name = fmt::format("{}.exposure_steps[{}].", group, i);
    if (step.frame <= previous) {
      Fail(name + "frame", static_cast<double>(step.frame), "later than the step before");
    }
    CheckRange(name + "gain", step.gain, 0.001, 1000);
    previous = step.frame;
  }
}

void CheckOmni(const Scene& scene) {
  if (!scene.omni) return;
  const OmniCamera& omni = *scene.omni;
  CheckGroup("omni", omni, kOmniFields);
  for (const double offset : omni.centre_offset_px) {
    CheckRange("omni.centre_offset_px", offset, -4096, 4096);
  }
  CheckSteps("omni", omni.exposure_steps);
  const double rim_m =
      omni.FocusM() + omni.mirror_a_m * std::hypot(1, omni.rim_radius_m / omni.mirror_b_m);
  if (!(omni.mount_height_m + rim_m < scene.room.height_m)) {
    Fail("omni.mount_height_m",
         omni.mount_height_m,
         fmt::format("so low that the mirror's rim, {:.3f} m higher, is below the ceiling "
                     "(room.height_m)",
                     rim_m));
  }
}

void CheckStructures(const Scene& scene) {
  constexpr double kMaxSolids = 2e6;
  double solids = 0;
  for (const Structure& of : scene.structures) {
    const std::string name = fmt::format("structures.{}", of.name);
    const bool plain = std::all_of(of.name.begin(), of.name.end(), [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '-' || c == '_';
    });
    if (!plain || of.name.empty()) {
      throw InputError(name + " has a wrong name, must consist of letters, digits, '-' and '_'");
    }
    CheckGroup(name.c_str(), of, kStructureFields);
    const bool round = (Only(of.kind) & kRoundStructures) != 0;
    const double top_m = of.height_m + (round ? of.width_m : of.depth_m);
    if (!(top_m <= scene.room.height_m)) {
      Fail(name + ".height_m",
           of.height_m,
           fmt::format("so low that its top, {:g} m higher, is not above the ceiling "
                       "(room.height_m)",
                       top_m - of.height_m));
    }
    const double room_m = of.along == Axis::kY ? scene.room.width_m : scene.room.length_m;
    const double end_m = of.to_m > 0 ? std::min(of.to_m, room_m) : room_m;
    if (!(of.from_m < end_m)) {
      Fail(name + ".from_m",
           of.from_m,
           fmt::format("less than the end of the runs, {:g} (to_m, or the room's end)", end_m));
    }
    solids += CountSolids(of, scene.room);
    if (solids > kMaxSolids) {
      Fail(name + ".every_m", of.every_m, "greater: the structures have more than a million parts");
    }
  }
}

void CheckMovers(const Scene& scene) {
  for (std::size_t i = 0; i < scene.movers.size(); ++i) {
    const Mover& mover = scene.movers[i];
    const std::string name = fmt::format("movers[{}]", i);
    CheckGroup(name.c_str(), mover, kMoverFields);
    if (!(mover.top_m > mover.bottom_m)) Fail(name + ".top_m", mover.top_m, "above bottom_m");
    if (!(mover.to_s >= mover.from_s)) Fail(name + ".to_s", mover.to_s, "not before from_s");
  }
}

/// Rows of a list. @param key  Its name.
template <typename Row, std::size_t N>
void CheckRows(const std::string& key,
               const std::vector<Row>& rows,
               const std::array<Field<Row>, N>& fields) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CheckGroup(fmt::format("{}[{}]", key, i).c_str(), rows[i], fields);
  }
}

void CheckTimes(const std::string& key, const std::vector<TimeSpan>& spans) {
  CheckRows(key, spans, kTimeSpanFields);
  for (std::size_t i = 0; i < spans.size(); ++i) {
    if (spans[i].to_s >= spans[i].from_s) continue;
    Fail(fmt::format("{}[{}].to_s", key, i), spans[i].to_s, "not before from_s");
  }
}

void CheckMotionSensors(const Scene& scene) {
  if (scene.wheels) {
    CheckGroup("wheels", *scene.wheels, kWheelsFields);
    CheckRows("wheels.slips", scene.wheels->slips, kSlipFields);
    CheckTimes("wheels.gaps", scene.wheels->gaps);
  }
  if (scene.gyro) CheckGroup("gyro", *scene.gyro, kGyroFields);
}

void CheckCarried(const std::vector<Carried>& carried) {
  CheckRows("path.carried", carried, kCarriedFields);
  for (std::size_t i = 1; i < carried.size(); ++i) {
    if (carried[i].at_s > carried[i - 1].at_s) continue;
    Fail(fmt::format("path.carried[{}].at_s", i), carried[i].at_s, "later than the row before");
  }
}

void CheckPath(const Scene& scene) {
  const Path& path = scene.path;
  if (path.kind == PathKind::kTum) {
    if (path.tum_file.empty()) {
      throw InputError("path.tum_file is missing, must be given for kind tum");
    }
    return;
  }
  const double length = scene.room.length_m;
  const double width = scene.room.width_m;
  if (path.kind == PathKind::kWaypoints) {
    if (path.waypoints_m.size() < 2) {
      throw InputError("path.waypoints_m is too short, must be at least two points");
    }
    for (std::size_t i = 0; i < path.waypoints_m.size(); ++i) {
      const std::string name = fmt::format("path.waypoints_m[{}].", i);
      CheckRange(name + "x", path.waypoints_m[i][0], 0, length);
      CheckRange(name + "y", path.waypoints_m[i][1], 0, width);
    }
    return;
  }
  const auto& area = path.area_m;
  if (!(area[0] >= 0 && area[2] > area[0] && area[2] <= length && area[1] >= 0 &&
        area[3] > area[1] && area[3] <= width)) {
    throw InputError(
        fmt::format("path.area_m = [{:g}, {:g}, {:g}, {:g}], must be x_min, y_min, x_max, y_max "
                    "inside of the room of {:g} x {:g} m",
                    area[0],
                    area[1],
                    area[2],
                    area[3],
                    length,
                    width));
  }
}

}  // namespace

std::string RangeText(double least, double most) {
  return fmt::format("in [{:g}, {:g}]", least, most);
}

void Scene::Validate() const {
  CheckRange("axle_behind_mast_m", axle_behind_mast_m, -10, 10);
  CheckGroup("room", room, kRoomFields);
  CheckGroup("ceiling", ceiling, kCeilingFields);
  CheckGroup("fixtures", fixtures, kFixtureFields);
  CheckGroup("picture", image, kImageFields);
  CheckGroup("path", path, kPathFields);
  CheckCamera("camera", camera, room);
  CheckGroup("camera", camera, kUpFields);
  CheckForward(*this);
  CheckOmni(*this);
  const double narrow = std::min(ceiling.tile_length_m, ceiling.tile_width_m);
  if (!(ceiling.joint_m < narrow)) {
    Fail("ceiling.joint_m", ceiling.joint_m, "narrower than a tile");
  }
  if (ceiling.symmetric && ceiling.tile_length_m != ceiling.tile_width_m) {
    Fail("ceiling.tile_width_m", ceiling.tile_width_m, "tile_length_m, since symmetric is true");
  }
  if (ceiling.symmetric && ceiling.lamp_every_x != ceiling.lamp_every_y) {
    Fail("ceiling.lamp_every_y", ceiling.lamp_every_y, "lamp_every_x, since symmetric is true");
  }
  CheckMarks(*this);
  CheckRows("ceiling.plain", ceiling.plain, kPlainFields);
  CheckBoxes(*this);
  CheckStructures(*this);
  CheckMovers(*this);
  CheckSteps("picture", image.exposure_steps);
  CheckTimes("picture.dark", image.dark);
  CheckMotionSensors(*this);
  CheckCarried(path.carried);
  CheckPath(*this);
  CheckDebris(*this);
}

}  // namespace ceilmap::simulator
