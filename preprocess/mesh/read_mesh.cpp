// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/read_mesh.h"

#include <fmt/format.h>

#include <limits>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_text.h"
#include "preprocess/readers/text/byte_source.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t mostTriangles = std::uint64_t{1} << 31;

using Parse = Result<TriangleMesh> (*)(std::string_view, const std::string&);

Parse parserOf(std::string_view bytes, const std::string& ending) {
    MeshText text(bytes.substr(0, 4096), "");
    const auto first = text.wordAcrossLines();
    if (first == "ply") return parsePly;
    if (isBinaryStl(bytes)) return parseStl;
    if (offMark(first)) return parseOff;
    if (ending == ".obj") return parseObj;
    if (ending == ".stl") return parseStl;
    if (ending == ".off") return parseOff;
    if (lower(first.substr(0, 16)) == "solid") return parseStl;
    if (first == "v" || first == "mtllib" || first == "o" || first == "g") return parseObj;
    return nullptr;
}

}  // namespace

std::string meshEnding(const fs::path& path) {
    const auto last = lower(path.extension().string());
    return last == ".gz" ? lower(path.stem().extension().string()) : last;
}

Result<ReadMesh> readMesh(const fs::path& path, std::uint64_t limit, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(
        auto bytes,
        wholeFile(path, limit,
                  fmt::format("has more than the {} MiB that memory allows, unpacked", limit >> 20),
                  progress));
    const auto name = path.filename().string();
    if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff")) {
        return unsupported(name, "is text in UTF-16, which is not read: save it as UTF-8");
    }
    const auto parse = parserOf(bytes, meshEnding(path));
    if (parse == nullptr) {
        return unsupported(name, "is no OBJ, PLY, STL or OFF file; of a volume --isovalue makes a mesh");
    }
    MOTE_ASSIGN_OR_RETURN(auto parsed, parse(bytes, name));
    bytes = {};
    if (parsed.positions.size() >= std::numeric_limits<std::uint32_t>::max() ||
        parsed.triangles.size() >= mostTriangles) {
        return Error{ErrorCode::resourceExhausted, name, "has more than 2^31 triangles or 2^32 vertices"};
    }
    if (progress.cancelled()) return wasCancelled();
    for (const auto& note : parsed.notes) progress.note(note);
    if (const auto origin = describeOrigin(parsed.origin); !origin.empty()) progress.note(origin);
    ReadMesh made;
    made.mesh = weldMesh(std::move(parsed), made.counts);
    if (!made.mesh.triangles.empty()) return made;
    const auto repairs = describeRepairs(made.counts);
    return unsupported(name, repairs.empty() ? "has no triangles" : "has no triangle to keep: " + repairs);
}

std::string describeRepairs(const MeshCounts& counts) {
    std::string text;
    const auto add = [&](std::uint64_t count, const char* what) {
        if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
    };
    add(counts.smallFaces, "faces of fewer than three corners left out");
    add(counts.tangled, "polygons of very many corners cut into triangles that may overlap");
    add(counts.notFinite, "triangles with a corner that is not finite or beyond 1e18 left out");
    add(counts.degenerate, "triangles without area left out");
    add(counts.repeated, "repeated triangles left out");
    add(counts.duplicates, "vertices at the place of another one merged");
    add(counts.unused, "vertices in no triangle left out");
    add(counts.needles, "needle triangles kept");
    return text;
}

}  // namespace mote::prep
