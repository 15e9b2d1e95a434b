# Debian packages by CPack, from the build folder: cpack -G DEB. They are ceilmap (the program), libceilmap-dev (libraries,
# headers, CMake package) and python3-ceilmap (the Python module). tests/package.sh builds and tries them.
set(CEILMAP_PACKAGE_MAINTAINER "ceilmap maintainers <maintainers@ceilmap.example>" CACHE STRING
  "Who publishes the Debian packages: name and mail address")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT ${CEILMAP_PACKAGE_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
# Each package has a summary of its own, the first line of its description.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# What only Debian asks for: compressed pages, copyright and changelog of each package.
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian/prepare.cmake)
set(CPACK_CEILMAP_SOURCE_DIR ${PROJECT_SOURCE_DIR})

set(CPACK_COMPONENTS_ALL program development)
if(TARGET ceilmap_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME ceilmap)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS gnuplot-nox)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "ceiling maps for mobile robots
ceilmap maps a ceiling from the video of a robot's upward camera, and localizes
this robot and others on that map. It compensates the tilt that debris causes,
and measures headings with a camera under a convex mirror or by colours.

This package has the program, its manual pages and completion for bash.")

# The static libraries need what they use inside; these packages are what find_package(ceilmap) looks for.
if(CEILMAP_FFT STREQUAL "fftw")
  set(fft_package libfftw3-dev)
else()
  set(fft_package libkissfft-dev)
endif()
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libceilmap-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
string(JOIN ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  libopencv-dev libeigen3-dev libceres-dev libyaml-cpp-dev libgdal-dev libsqlite3-dev nlohmann-json3-dev libspdlog-dev
  libfmt-dev ${fft_package})
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "ceiling maps for mobile robots - libraries
ceilmap maps a ceiling from the video of a robot's upward camera, and localizes
this robot and others on that map.

This package has the static C++ libraries, their headers, and the CMake package
for find_package(ceilmap); ceilmap::robot is the one for a robot's program.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-ceilmap)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
# The module is compiled for one version of Python.
find_package(Python3 QUIET COMPONENTS Interpreter)
math(EXPR next_python_minor "${Python3_VERSION_MINOR} + 1" OUTPUT_FORMAT DECIMAL)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}), python3 (<< ${Python3_VERSION_MAJOR}.${next_python_minor}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "ceiling maps for mobile robots - Python module
ceilmap maps a ceiling from the video of a robot's upward camera, and localizes
this robot and others on that map.

This package has the Python module: mapping, localization and registration of
numpy arrays, and reading of maps.")

include(CPack)
