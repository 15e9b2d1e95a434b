# The real program on recordings that the tests make.
ceilmap_add_test(commands_test
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/bad_input_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/child_process.cpp
    ${CMAKE_CURRENT_LIST_DIR}/commands_test.cpp
  LINKS ceilmap_app opencv_core opencv_imgproc opencv_imgcodecs opencv_videoio)
target_compile_definitions(commands_test PRIVATE CEILMAP_EXE="$<TARGET_FILE:ceilmap>")
add_dependencies(commands_test ceilmap)
