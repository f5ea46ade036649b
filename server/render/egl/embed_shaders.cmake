# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -DOUTPUT=FILE -DDIRECTORY=DIR -DSHADERS="a.comp,b.glsl" -P embed_shaders.cmake
# Writes a header that holds each shader file as a string literal.
string(REPLACE "," ";" SHADERS "${SHADERS}")
set(text "// Made from egl/shaders by embed_shaders.cmake.\n#pragma once\n\n#include <array>\n#include <string_view>\n#include <utility>\n\nnamespace mote::render {\n\n")
list(LENGTH SHADERS count)
string(APPEND text "inline constexpr std::array<std::pair<std::string_view, std::string_view>, ${count}> embeddedShaders{{\n")
foreach(shader IN LISTS SHADERS)
  file(READ "${DIRECTORY}/${shader}" source)
  string(APPEND text "{\"${shader}\", R\"MOTE_SHADER(${source})MOTE_SHADER\"},\n")
endforeach()
string(APPEND text "}};\n\n}  // namespace mote::render\n")
file(WRITE "${OUTPUT}" "${text}")
