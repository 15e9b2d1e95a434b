# One place for what all targets share: include root, warnings, sanitizers.

set(CEILMAP_ROOT ${CMAKE_CURRENT_LIST_DIR}/..)
cmake_path(NORMAL_PATH CEILMAP_ROOT)

add_library(ceilmap_build_flags INTERFACE)
target_compile_options(ceilmap_build_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wunused)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees an overlap in every '"text" + std::string' (GCC bug 105651, mended in 13).
  target_compile_options(ceilmap_build_flags INTERFACE -Wno-restrict)
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

# ceilmap_add_library(NAME SOURCES ... LINKS ...): the library ceilmap::NAME of the calling folder. Headers are
# included from the project's root ("calib/pose2.hpp"), in the build tree and installed alike.
function(ceilmap_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(ceilmap_${name} STATIC ${ARG_SOURCES})
  add_library(ceilmap::${name} ALIAS ceilmap_${name})
  target_compile_features(ceilmap_${name} PUBLIC cxx_std_20)
  target_include_directories(ceilmap_${name} PUBLIC
    $<BUILD_INTERFACE:${CEILMAP_ROOT}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/ceilmap>)
  target_link_libraries(ceilmap_${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS}
    $<BUILD_INTERFACE:ceilmap_build_flags>)
  set_target_properties(ceilmap_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY CEILMAP_LIBRARIES ceilmap_${name})
endfunction()
