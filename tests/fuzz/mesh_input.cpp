// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/read_mesh.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

constexpr std::uint64_t mostBytes = 1 << 20;  // of a file, inflated

void checkMesh(const prep::TriangleMesh& mesh) {
    for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) require(corner < mesh.positions.size());
    }
    require(mesh.parts.empty() || mesh.parts.size() == mesh.triangles.size());
}

std::string parsed(const Result<prep::TriangleMesh>& mesh) {
    if (!mesh) return mesh.error().toString();
    checkMesh(*mesh);
    return "";
}

std::string whole(std::string_view bytes) {
    const MemoryFile file(bytes);
    Silent progress;
    const auto read = prep::readMesh(file.path(), mostBytes, progress);
    if (!read) return read.error().toString();
    require(!read->mesh.triangles.empty());
    checkMesh(read->mesh);
    const auto& counts = read->counts;
    const bool repaired = counts.notFinite + counts.degenerate + counts.repeated + counts.duplicates +
                              counts.unused + counts.needles >
                          0;
    require(prep::describeRepairs(counts).empty() != repaired);
    for (const auto& place : read->mesh.positions) {
        require(std::isfinite(place.x) && std::isfinite(place.y) && std::isfinite(place.z));
    }
    return "";
}

}  // namespace

std::string meshInput(std::string_view input) {
    const auto [format, bytes] = firstLine(input);
    const std::string name = "mesh";
    if (format == "obj") return parsed(prep::parseObj(bytes, name));
    if (format == "off") return parsed(prep::parseOff(bytes, name));
    if (format == "ply") return parsed(prep::parsePly(bytes, name));
    if (format == "stl") return parsed(prep::parseStl(bytes, name));
    return whole(bytes);
}

}  // namespace mote::test
