# The real program on recordings that the tests make.
ceilmap_add_test(commands_test RUNS_PROGRAM COST 100 SHARDS 2
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/align_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/bad_input_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/bag_output_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/commands_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/diff_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/evaluate_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/help_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/localize_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/map_file_commands_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/plan_page_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/prune_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/remote_map_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/report_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/rig_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/update_command_test.cpp
  LINKS ceilmap_app ceilmap_test_support PkgConfig::httplib GDAL::GDAL opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(heading_command_test COST 40
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/heading_bad_input_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/heading_command_test.cpp
  LINKS ceilmap_app ceilmap_test_support opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(bag_command_test RUNS_PROGRAM COST 45
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/bag_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/recording_bag.cpp
  LINKS ceilmap_app ceilmap_test_support ceilmap_bags)

# For measurements (tests/bench/README.md).
add_executable(ceilmap_write_recording_bag
  ${CMAKE_CURRENT_LIST_DIR}/recording_bag.cpp
  ${CMAKE_CURRENT_LIST_DIR}/write_recording_bag.cpp)
target_link_libraries(ceilmap_write_recording_bag PRIVATE ceilmap_app ceilmap_bags ceilmap_build_flags)

ceilmap_add_test(stream_test RUNS_PROGRAM COST 20
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/live_camera.cpp
    ${CMAKE_CURRENT_LIST_DIR}/stream_test.cpp
  LINKS ceilmap_app ceilmap_test_support PkgConfig::ffmpeg PkgConfig::httplib opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(simulate_test RUNS_PROGRAM COST 20
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/simulate_test.cpp
  LINKS ceilmap_app ceilmap_test_support opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(wheels_command_test RUNS_PROGRAM
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/wheels_command_test.cpp
  LINKS ceilmap_app ceilmap_test_support)

ceilmap_add_test(lens_test RUNS_PROGRAM
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/lens_test.cpp
  LINKS ceilmap_app ceilmap_test_support opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(tilt_test RUNS_PROGRAM COST 35
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/tilt_test.cpp
  LINKS ceilmap_app ceilmap_test_support fmt::fmt opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(sites_test RUNS_PROGRAM COST 45
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/durability_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/sites_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/solve_command_test.cpp
  LINKS ceilmap_app ceilmap_test_support opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(site_command_test RUNS_PROGRAM COST 20
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/site_test.cpp
  LINKS ceilmap_app ceilmap_test_support opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(heading_test RUNS_PROGRAM COST 15
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/heading_test.cpp
  LINKS ceilmap_app ceilmap_test_support fmt::fmt opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(compass_command_test RUNS_PROGRAM COST 90 SHARDS 2
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/compass_bad_input_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/compass_command_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/heading_model_test.cpp
  LINKS ceilmap_app ceilmap_test_support fmt::fmt opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(calibrate_camera_test COST 45
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/../calib/solve/painted_board.cpp
    ${CMAKE_CURRENT_LIST_DIR}/calibrate_camera_test.cpp
  LINKS ceilmap_app ceilmap_test_support fmt::fmt opencv_calib3d opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(calibrate_check_test RUNS_PROGRAM COST 70
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/calibrate_check_test.cpp
  LINKS ceilmap_app ceilmap_test_support opencv_core)

ceilmap_add_test(calibrate_rig_test RUNS_PROGRAM COST 100
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/calibrate_rig_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/calibrate_rig_wheels_test.cpp
  LINKS ceilmap_app ceilmap_test_support fmt::fmt opencv_core)

ceilmap_add_test(calibrate_mirror_test RUNS_PROGRAM
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/calibrate_mirror_test.cpp
  LINKS ceilmap_app ceilmap_test_support fmt::fmt opencv_core)

ceilmap_add_test(settings_test RUNS_PROGRAM
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/settings_test.cpp
  LINKS ceilmap_app ceilmap_commands ceilmap_test_support opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)

ceilmap_add_test(readme_test RUNS_PROGRAM COST 150
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/readme_test.cpp
  LINKS ceilmap_test_support)
