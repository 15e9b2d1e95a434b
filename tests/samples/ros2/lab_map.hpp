#pragma once

#include <gtest/gtest.h>

#include "ceilmap_ros/logic/mapping_logic.hpp"
#include "tests/samples/ros2/lab_drive.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap_ros {

/// Maps of the first part of samples/lab-map, made by the mapping logic.
struct LabMap {
  static constexpr int kFrames = 60;

  LabMap() { Make(file, {}); }

  void Make(const std::filesystem::path& map, const Pose2& origin) const {
    MappingOptions params;
    params.map = map;
    params.mapper.mapping.origin = origin;
    MappingLogic mapping(LabDrive::Rig(), params);
    for (int i = 0; i < kFrames; ++i) {
      drive.Send(i, mapping.Sensors());
      (void)mapping.Step(LabDrive::StampOf(i));
    }
    SaveResult saved;
    mapping.RequestSave({}, [&](const SaveResult& result) { saved = result; });
    (void)mapping.Step(LabDrive::StampOf(kFrames));
    EXPECT_TRUE(saved.success) << saved.message;
  }

  ceilmap::support::TempFolder folder;
  std::filesystem::path file = folder / "lab.gpkg";
  LabDrive drive{kFrames};
};

}  // namespace ceilmap_ros
