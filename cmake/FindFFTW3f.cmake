# FFTW in single precision, as the imported target FFTW3f::FFTW3f (Debian's FFTW ships no usable CMake package).
find_path(FFTW3F_INCLUDE_DIR fftw3.h)
find_library(FFTW3F_LIBRARY fftw3f)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFTW3f REQUIRED_VARS FFTW3F_LIBRARY FFTW3F_INCLUDE_DIR)
if(FFTW3f_FOUND AND NOT TARGET FFTW3f::FFTW3f)
  add_library(FFTW3f::FFTW3f UNKNOWN IMPORTED)
  set_target_properties(FFTW3f::FFTW3f PROPERTIES
    IMPORTED_LOCATION "${FFTW3F_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${FFTW3F_INCLUDE_DIR}")
endif()
mark_as_advanced(FFTW3F_INCLUDE_DIR FFTW3F_LIBRARY)
