// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes and pictures, which are read whole.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "preprocess/image/read_picture.h"
#include "preprocess/kept_notes.h"
#include "preprocess/look/look_at.h"
#include "preprocess/look/silent_notes.h"
#include "preprocess/mesh/read_mesh.h"

namespace mote::prep {
namespace {

void addBounds(const TriangleMesh& mesh, Found& found) {
    glm::dvec3 low(mesh.positions.front()), high = low;
    for (const glm::vec3& place : mesh.positions) {
        low = glm::min(low, glm::dvec3(place));
        high = glm::max(high, glm::dvec3(place));
    }
    for (int axis = 0; axis < 3; ++axis) {
        FoundColumn column{std::string(1, "xyz"[axis]), ""};
        column.low = low[axis] + mesh.origin[axis];
        column.high = high[axis] + mesh.origin[axis];
        found.columns.push_back(std::move(column));
    }
}

}  // namespace

Result<std::vector<Found>> lookAtMesh(const std::filesystem::path& input, const LookOptions& options,
                                      Progress& progress) {
    SilentNotes silent(progress);
    KeptNotes notes(silent);
    MOTE_ASSIGN_OR_RETURN(const auto read, readMesh(input, memoryFor(options.memory) / 4, notes));
    const MeshCounts& counts = read.counts;
    Found found;
    found.kind = "mesh";
    const std::string ending = meshEnding(input);
    found.format = ending.substr(std::min<std::size_t>(1, ending.size()));
    found.told = "its first words, else its name's ending";
    found.facts.push_back({"vertices", counts.vertices, "vertices", fmt::format("{}", counts.vertices)});
    const auto kept = static_cast<std::uint64_t>(read.mesh.triangles.size());
    found.facts.push_back({"faces", counts.triangles, "faces",
                           fmt::format("{} triangles, {} of which are kept", counts.triangles, kept)});
    found.facts.push_back({"triangles", kept});
    found.facts.push_back({"unit", std::string(), "unit", "not said: give it (--unit)"});
    addBounds(read.mesh, found);
    found.notes = notes.notes();
    if (const auto repairs = describeRepairs(counts); !repairs.empty()) found.notes.push_back(repairs);
    return std::vector<Found>{std::move(found)};
}

Result<std::vector<Found>> lookAtImage(const std::filesystem::path& input, const LookOptions& options,
                                       Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const char* const format, pictureFormat(input));
    MOTE_ASSIGN_OR_RETURN(const auto picture, readPicture(input, options.memory, progress));
    const auto& luminance = picture.luminance;
    Found found;
    found.kind = "image";
    found.format = format;
    found.told = "its first bytes";
    const std::vector<std::uint64_t> size{luminance.width, luminance.height};
    found.facts.push_back({"size", size, "size", fmt::format("{} pixels", fmt::join(size, " x "))});
    found.facts.push_back({"color", picture.color, "channels", picture.color ? "colour" : "grey"});
    found.facts.push_back({"colorSpace", picture.colorSpace, "encoded", picture.colorSpace});
    if (picture.color) found.notes.emplace_back("of colours the luminance is taken (ITU-R BT.709)");
    if (picture.transparent) found.notes.emplace_back("what is transparent is laid on white");
    if (picture.invalid > 0)
        found.notes.push_back(fmt::format("{} pixels are not finite and taken as white", picture.invalid));
    FoundColumn range{"luminance", ""};
    for (const float value : luminance.values) range.take(static_cast<double>(value));
    found.columns.push_back(std::move(range));
    return std::vector<Found>{std::move(found)};
}

}  // namespace mote::prep
