// SPDX-License-Identifier: GPL-3.0-or-later
//
// The mesh formats: each a function from a file's bytes, which nobody vouches for, to triangles. Every count
// in them is held to the bytes that there are before memory is taken for it; every index is below the number
// of vertices. `name` is the file's, for errors. Functions without state.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "preprocess/mesh/triangle_mesh.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// Wavefront: v and f with any of its index forms, negative ones too; polygons; lines that go on; the rest is
/// left aside. Faces of one combination of g, o and usemtl are a part, wherever they stand. Errors: corrupt
/// with the line.
Result<TriangleMesh> parseObj(std::string_view text, const std::string& name);

/// Geomview: OFF with its prefixes ST, C and N, ASCII. Errors: corrupt with the line, unsupported (binary,
/// 4OFF, nOFF).
Result<TriangleMesh> parseOff(std::string_view text, const std::string& name);

/// Where in the first word of a file "OFF" stands, with its prefixes and perhaps a count right behind it.
std::optional<std::size_t> offMark(std::string_view word);

/// Stanford: ASCII and binary of either byte order; faces of any integer type, strips with -1 between them;
/// elements and properties that we do not know are stepped over. Errors: corrupt with line or byte,
/// unsupported.
Result<TriangleMesh> parsePly(std::string_view bytes, const std::string& name);

/// Stereolithography, ASCII or binary. A file whose length is that of a binary one is binary, though it begin
/// with "solid"; one that says 0 triangles has those that follow. Errors: corrupt with line or byte.
Result<TriangleMesh> parseStl(std::string_view bytes, const std::string& name);

/// Whether the length is that of a binary STL with its own count of triangles.
bool isBinaryStl(std::string_view bytes);

}  // namespace mote::prep
