# Run by CPack when the files of all packages are in its folder and the packages are not made yet: adds copyright and
# changelog, and compresses what Debian wants compressed.
cmake_minimum_required(VERSION 3.25)
set(debian ${CPACK_CEILMAP_SOURCE_DIR}/cmake/debian)

# The time of the last change, so that the same sources give the same package.
set(seconds $ENV{SOURCE_DATE_EPOCH})
if(NOT seconds)
  execute_process(COMMAND git -C ${CPACK_CEILMAP_SOURCE_DIR} log -1 --format=%ct
    OUTPUT_VARIABLE seconds OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT seconds)
  string(TIMESTAMP seconds %s)
endif()
execute_process(COMMAND date --utc --rfc-email --date=@${seconds}
  OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(share ${CPACK_TEMPORARY_DIRECTORY}/${component}${CPACK_PACKAGING_INSTALL_PREFIX}/share)
  set(documents ${share}/doc/${package})
  file(COPY ${debian}/copyright DESTINATION ${documents})
  execute_process(
    COMMAND awk -f ${debian}/changelog.awk -v package=${package} -v version=${CPACK_PACKAGE_VERSION}
      -v "maintainer=${CPACK_PACKAGE_CONTACT}" -v "date=${date}" ${CPACK_CEILMAP_SOURCE_DIR}/CHANGELOG.md
    OUTPUT_FILE ${documents}/changelog COMMAND_ERROR_IS_FATAL ANY)
  file(GLOB pages ${share}/man/man1/*.1)
  execute_process(COMMAND gzip -9nf ${documents}/changelog ${pages} COMMAND_ERROR_IS_FATAL ANY)
  file(CHMOD_RECURSE ${share} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ
    DIRECTORY_PERMISSIONS ${CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})
endforeach()
