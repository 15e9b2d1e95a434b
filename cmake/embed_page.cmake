# Puts the page, its styles, scripts and libraries together and writes them as a C++ source:
#   cmake -DHTML=... -DSTYLES="..." -DLIBRARIES="..." -DSCRIPTS="..." -DOUTPUT=page_template.cpp -P embed_page.cmake
# In HTML, {{styles}}, {{libraries}} and {{scripts}} are the places of the files and {{script_hashes}}, {{style_hashes}}
# those of their hashes in the Content-Security-Policy: nothing but them may run.
cmake_minimum_required(VERSION 3.25)

# All files, one behind the other, as they may stand in a script or style element.
function(read_files result)
  set(all "")
  foreach(file IN LISTS ARGN)
    file(READ "${file}" text)
    # Source maps are not here, and browsers would look for them.
    string(REGEX REPLACE "//# sourceMappingURL=[^\n]*" "" text "${text}")
    string(REGEX REPLACE "/\\*# sourceMappingURL=[^\n]*\\*/" "" text "${text}")
    # Pictures neither: they belong to controls that the page does not have.
    string(REGEX REPLACE "background-image:url\\(images/[^)]*\\);?" "" text "${text}")
    string(REPLACE "</script" "<\\/script" text "${text}")
    string(REPLACE "\r" "" text "${text}")
    string(APPEND all "${text}\n")
  endforeach()
  set(${result} "${all}" PARENT_SCOPE)
endfunction()

# Hex digits as base64: six of them, 24 bits, make four characters.
function(base64_of_hex result hex)
  set(digits "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")
  string(LENGTH "${hex}" length)
  math(EXPR missing "(6 - ${length} % 6) % 6 / 2")
  string(REPEAT "00" ${missing} zeros)
  string(APPEND hex "${zeros}")
  string(REGEX MATCHALL "......" groups "${hex}")
  set(text "")
  foreach(group IN LISTS groups)
    foreach(shift 18 12 6 0)
      math(EXPR digit "0x${group} >> ${shift} & 63")
      string(SUBSTRING "${digits}" ${digit} 1 character)
      string(APPEND text "${character}")
    endforeach()
  endforeach()
  string(LENGTH "${text}" length)
  math(EXPR length "${length} - ${missing}")
  string(SUBSTRING "${text}" 0 ${length} text)
  string(REPEAT "=" ${missing} padding)
  set(${result} "${text}${padding}" PARENT_SCOPE)
endfunction()

function(csp_hash result text)
  string(SHA256 hex "${text}")
  base64_of_hex(base64 "${hex}")
  set(${result} "'sha256-${base64}'" PARENT_SCOPE)
endfunction()

read_files(styles ${STYLES})
read_files(libraries ${LIBRARIES})
read_files(scripts ${SCRIPTS})
# The page's own scripts share one scope that nobody else sees.
set(scripts "(() => {\n'use strict';\n${scripts}})();\n")
csp_hash(styles_hash "${styles}")
csp_hash(libraries_hash "${libraries}")
csp_hash(scripts_hash "${scripts}")

file(READ "${HTML}" page)
string(REPLACE "{{style_hashes}}" "${styles_hash}" page "${page}")
string(REPLACE "{{script_hashes}}" "${libraries_hash} ${scripts_hash}" page "${page}")
string(REPLACE "{{styles}}" "${styles}" page "${page}")
string(REPLACE "{{libraries}}" "${libraries}" page "${page}")
string(REPLACE "{{scripts}}" "${scripts}" page "${page}")
file(WRITE "${OUTPUT}.html" "${page}")

file(READ "${OUTPUT}.html" bytes HEX)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
string(REGEX REPLACE "(('....',){16})" "\\1\n" bytes "${bytes}")
file(WRITE "${OUTPUT}" "// Made from page.html by embed_page.cmake.
#include \"app/page/page_template.hpp\"

namespace ceilmap::page {
namespace {

constexpr char kPage[] = {
${bytes}};

}  // namespace

std::string_view PageTemplate() { return {kPage, sizeof(kPage)}; }

}  // namespace ceilmap::page
")
