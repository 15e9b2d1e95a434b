# One place for what all targets share: include root, warnings, sanitizers, precompiled headers.

set(CEILMAP_ROOT ${CMAKE_CURRENT_LIST_DIR}/..)
cmake_path(NORMAL_PATH CEILMAP_ROOT)

add_library(ceilmap_build_flags INTERFACE)
target_compile_options(ceilmap_build_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wunused)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees an overlap in every '"text" + std::string' (GCC bug 105651, mended in 13).
  target_compile_options(ceilmap_build_flags INTERFACE -Wno-restrict)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC collects its garbage from 128 MB on, again and again. A compiler takes up to 2 GB with this (1.8 GB without) and a
  # tenth less time.
  target_compile_options(ceilmap_build_flags INTERFACE "SHELL:--param ggc-min-heapsize=1000000")
endif()
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC takes sources that are compiled as one for headers, whose anonymous namespaces would differ from use to use.
  target_compile_options(ceilmap_build_flags INTERFACE -Wno-subobject-linkage)
endif()
if(CEILMAP_WERROR)
  target_compile_options(ceilmap_build_flags INTERFACE -Werror)
endif()
if(CEILMAP_SANITIZE)
  target_compile_options(ceilmap_build_flags INTERFACE -fsanitize=${CEILMAP_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(ceilmap_build_flags INTERFACE -fsanitize=${CEILMAP_SANITIZE})
  target_compile_definitions(ceilmap_build_flags INTERFACE CEILMAP_SANITIZED)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Instrumented code confuses this warning, in the standard library's own headers too (GCC bug 105562).
    target_compile_options(ceilmap_build_flags INTERFACE -Wno-maybe-uninitialized)
  endif()
endif()
target_compile_definitions(ceilmap_build_flags INTERFACE $<$<CONFIG:Debug>:EIGEN_INITIALIZE_MATRICES_BY_NAN>)

# Parsing OpenCV, Eigen and GoogleTest took half of the build, so that it is done once for the libraries and once for the
# tests. For the same reason the preset release compiles several sources of a target as one (CMAKE_UNITY_BUILD), so that
# names in the anonymous namespaces of one target are unique. Sources include what they use all the same:
# tests/check-style.sh --deep compiles each alone and without precompiled headers.
set(CEILMAP_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numbers> <optional>
  <random> <span> <string> <thread> <utility> <vector>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <opencv2/core.hpp> <opencv2/imgproc.hpp>)

# ceilmap_add_precompiled(NAME LINKS ... HEADERS ...): a target for other targets' REUSE_FROM. They must be compiled with
# the same flags, and with the same definitions as far as the headers look at them.
function(ceilmap_add_precompiled name)
  cmake_parse_arguments(ARG "" "" "LINKS;HEADERS" ${ARGN})
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp "")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} ceilmap_build_flags)
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
  set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
endfunction()

# ceilmap_add_library(NAME SOURCES ... [INTERNAL_HEADERS ...] LINKS ...): the library ceilmap::NAME of the calling folder.
# Headers are included from the project's root ("calib/pose2.hpp"), in the build tree and installed alike. All headers of
# the folder are installed but INTERNAL_HEADERS, which no public header includes.
function(ceilmap_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;INTERNAL_HEADERS;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(ceilmap_${name} STATIC ${ARG_SOURCES})
  add_library(ceilmap::${name} ALIAS ceilmap_${name})
  target_compile_features(ceilmap_${name} PUBLIC cxx_std_20)
  target_include_directories(ceilmap_${name} PUBLIC
    $<BUILD_INTERFACE:${CEILMAP_ROOT}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/ceilmap>)
  target_link_libraries(ceilmap_${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS}
    $<BUILD_INTERFACE:ceilmap_build_flags>)
  # The headers were precompiled with fmt's definitions, so that all have them.
  target_link_libraries(ceilmap_${name} PRIVATE $<BUILD_INTERFACE:fmt::fmt>)
  target_precompile_headers(ceilmap_${name} REUSE_FROM ceilmap_library_headers)
  set_target_properties(ceilmap_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY CEILMAP_LIBRARIES ceilmap_${name})
  file(GLOB headers CONFIGURE_DEPENDS *.hpp)
  foreach(header IN LISTS ARG_INTERNAL_HEADERS)
    set(path ${CMAKE_CURRENT_SOURCE_DIR}/${header})
    if(NOT path IN_LIST headers)
      message(FATAL_ERROR "ceilmap_add_library(${name}): there is no header ${path}")
    endif()
    list(REMOVE_ITEM headers ${path})
  endforeach()
  target_sources(ceilmap_${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${CEILMAP_ROOT} FILES ${headers})
endfunction()
