# Installs the program, the libraries and what find_package(ceilmap) needs of them: targets ceilmap::calib,
# ceilmap::registration, ceilmap::mapping, ceilmap::simulator, ...; their public headers under include/ceilmap as they are
# included.
include(CMakePackageConfigHelpers)

set(CEILMAP_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/ceilmap)
get_property(CEILMAP_INSTALLED_LIBRARIES GLOBAL PROPERTY CEILMAP_LIBRARIES)

install(TARGETS ${CEILMAP_INSTALLED_LIBRARIES}
  EXPORT ceilmapTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ceilmap COMPONENT development)
if(TARGET ceilmap)
  install(TARGETS ceilmap RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

install(EXPORT ceilmapTargets NAMESPACE ceilmap:: DESTINATION ${CEILMAP_CONFIG_DIR} COMPONENT development)
configure_package_config_file(cmake/ceilmapConfig.cmake.in ${PROJECT_BINARY_DIR}/ceilmapConfig.cmake
  INSTALL_DESTINATION ${CEILMAP_CONFIG_DIR})
# Before 1.0 a change of the minor number may break users of the libraries.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ceilmapConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/ceilmapConfig.cmake ${PROJECT_BINARY_DIR}/ceilmapConfigVersion.cmake
  $<$<STREQUAL:${CEILMAP_FFT},fftw>:${PROJECT_SOURCE_DIR}/cmake/FindFFTW3f.cmake>
  DESTINATION ${CEILMAP_CONFIG_DIR} COMPONENT development)
