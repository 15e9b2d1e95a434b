# Writes a C++ function that returns a text file, or the part of it from a line on and up to the next heading of its kind:
#   cmake -DINPUT=FILES.md [-DFROM="## Heading"] -DHEADER=a/b.hpp -DFUNCTION=FilesText -DNAMESPACE=ceilmap::x -DOUTPUT=x.cpp
#     -P embed_text.cmake
cmake_minimum_required(VERSION 3.25)

file(READ "${INPUT}" text)
if(FROM)
  string(FIND "\n${text}" "\n${FROM}\n" begin)
  if(begin EQUAL -1)
    message(FATAL_ERROR "${INPUT} has no line '${FROM}'")
  endif()
  string(LENGTH "${FROM}\n" heading)
  math(EXPR begin "${begin} + ${heading}")
  string(SUBSTRING "${text}" ${begin} -1 text)
  string(FIND "${text}" "\n## " end)
  string(SUBSTRING "${text}" 0 ${end} text)
endif()
string(HEX "${text}" bytes)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
string(REGEX REPLACE "(('....',){16})" "\\1\n" bytes "${bytes}")
get_filename_component(name "${INPUT}" NAME)
file(WRITE "${OUTPUT}" "// Made from ${name} by embed_text.cmake.
#include \"${HEADER}\"

namespace ${NAMESPACE} {

std::string_view ${FUNCTION}() {
  static constexpr char kText[] = {
${bytes}};
  return {kText, sizeof(kText)};
}

}  // namespace ${NAMESPACE}
")
