// SPDX-License-Identifier: GPL-3.0-or-later
//
// The same small mesh, a tetrahedron, as a file of each format; and what reads them in tests. Any thread.
#pragma once

#include <string>
#include <vector>

#include "preprocess/mesh/read_mesh.h"

namespace mote::test {

struct SampleFile {
    std::string name;  ///< "tetrahedron.ply"
    std::string bytes;
};

/// Corners 0 and the unit vectors; four triangles, outwards.
std::vector<SampleFile> tetrahedronFiles();
std::string binaryStl(const std::string& header, const std::vector<std::array<glm::vec3, 3>>& triangles);
std::string binaryPly(bool bigEndian);

/// By way of a file, as the job does it.
Result<prep::ReadMesh> readBytes(const SampleFile& file, std::uint64_t limit = std::uint64_t{1} << 30);

/// Volume that the triangles enclose, by the divergence theorem: positive where they point outwards.
double enclosedVolume(const prep::TriangleMesh& mesh);

}  // namespace mote::test
