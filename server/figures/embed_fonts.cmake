# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -DOUTPUT=FILE -DUPRIGHT=FILE.ttf -DITALIC=FILE.ttf -P embed_fonts.cmake
# Writes a header that holds each font file's bytes: a figure has the same glyphs on every machine.
set(text "// Made from font files by embed_fonts.cmake.\n#pragma once\n\nnamespace mote::server {\n\n")
foreach(name IN ITEMS UPRIGHT ITALIC)
  file(READ "${${name}}" bytes HEX)
  string(TOLOWER "${name}" lower)
  string(REGEX REPLACE "(................................................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND text "inline constexpr unsigned char ${lower}Font[] = {\n${bytes}};\n")
endforeach()
string(APPEND text "\n}  // namespace mote::server\n")
file(WRITE "${OUTPUT}" "${text}")
