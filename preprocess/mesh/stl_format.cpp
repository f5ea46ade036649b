// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_text.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

constexpr std::size_t headerBytes = 84;    // 80 of text, then the count
constexpr std::size_t triangleBytes = 50;  // normal, three corners, two bytes of attributes

static_assert(std::endian::native == std::endian::little, "STL numbers are read as they lie");

std::uint64_t statedTriangles(std::string_view bytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    return count;
}

void addCorner(ExactMesh& mesh, const glm::dvec3& position) {
    mesh.positions.push_back(position);
    const auto count = static_cast<std::uint32_t>(mesh.positions.size());
    if (count % 3 == 0) mesh.triangles.push_back({count - 3, count - 2, count - 1});
}

Result<ExactMesh> parseBinary(std::string_view bytes, const std::string& name) {
    auto count = statedTriangles(bytes);
    const auto held = (bytes.size() - headerBytes) / triangleBytes;
    if (count > held) {
        return corrupt(fmt::format("{}: byte 80", name),
                       fmt::format("says {} triangles, and there are bytes for {}", count, held));
    }
    ExactMesh mesh;
    if (count == 0 && held > 0) {
        // Who wrote them as they came did not know how many there would be.
        mesh.notes.push_back(fmt::format("{}: says 0 triangles; the {} that follow were read", name, held));
        count = held;
    } else if (count < held) {
        mesh.notes.push_back(fmt::format("{}: says {} triangles; bytes for {} more follow and were left out",
                                         name, count, held - count));
    }
    mesh.positions.reserve(3 * count);
    mesh.triangles.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        const char* at = bytes.data() + headerBytes + i * triangleBytes + 3 * sizeof(float);
        for (int corner = 0; corner < 3; ++corner) {
            glm::vec3 position;
            std::memcpy(&position, at + corner * sizeof position, sizeof position);
            addCorner(mesh, glm::dvec3(position));
        }
    }
    return mesh;
}

Result<ExactMesh> parseAscii(std::string_view text, const std::string& name) {
    MeshText words(text, name);
    ExactMesh mesh;
    while (words.nextLine()) {
        const auto key = lower(words.word().substr(0, 16));
        if (key == "endfacet" && mesh.positions.size() % 3 != 0) {
            return words.error("a facet ends that has not three vertices");
        }
        if (key != "vertex") continue;
        MOTE_ASSIGN_OR_RETURN(const auto position, words.place());
        addCorner(mesh, position);
    }
    if (mesh.positions.size() % 3 != 0) return words.error("ends within a facet");
    return mesh;
}

}  // namespace

bool isBinaryStl(std::string_view bytes) {
    return bytes.size() >= headerBytes &&
           bytes.size() == headerBytes + triangleBytes * statedTriangles(bytes);
}

Result<TriangleMesh> parseStl(std::string_view bytes, const std::string& name) {
    // Some programs write bytes behind the last triangle, some begin a binary file with "solid": where no
    // facet follows, it is no text.
    const auto head = lower(bytes.substr(0, 1024));
    const auto has = [&](const char* word) { return head.find(word) != std::string::npos; };
    const bool text = !isBinaryStl(bytes) && has("solid") && (has("facet") || has("endsolid"));
    if (!text && bytes.size() < headerBytes) {
        return corrupt(name, "is too short for an STL file");
    }
    MOTE_ASSIGN_OR_RETURN(auto mesh, text ? parseAscii(bytes, name) : parseBinary(bytes, name));
    return toFloats(std::move(mesh));
}

}  // namespace mote::prep
