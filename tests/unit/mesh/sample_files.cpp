// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/mesh/sample_files.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <glm/geometric.hpp>

#include "tests/support/deflate.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

constexpr std::array<std::array<int, 3>, 4> faces{{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
constexpr std::array<std::array<float, 3>, 4> sampleCorners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

template <class T>
void append(std::string& bytes, T value, bool bigEndian = false) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    if (bigEndian) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
}

std::string asciiStl() {
    std::string text = "solid tetrahedron\n";
    for (const auto& face : faces) {
        text += "facet normal 0 0 0\n  outer loop\n";
        for (const int corner : face) {
            text += "    vertex";
            for (const float x : sampleCorners[static_cast<std::size_t>(corner)])
                text += " " + std::to_string(x);
            text += "\n";
        }
        text += "  endloop\nendfacet\n";
    }
    return text + "endsolid\n";
}

std::vector<std::array<glm::vec3, 3>> triangles() {
    std::vector<std::array<glm::vec3, 3>> all;
    for (const auto& face : faces) {
        auto& triangle = all.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& corner = sampleCorners[static_cast<std::size_t>(face[i])];
            triangle[i] = {corner[0], corner[1], corner[2]};
        }
    }
    return all;
}

}  // namespace

std::string binaryStl(const std::string& header, const std::vector<std::array<glm::vec3, 3>>& all) {
    std::string bytes = header;
    bytes.resize(80, ' ');
    append(bytes, static_cast<std::uint32_t>(all.size()));
    for (const auto& triangle : all) {
        append(bytes, glm::vec3(0.0F));
        for (const auto& corner : triangle) append(bytes, corner);
        append(bytes, std::uint16_t{0});
    }
    return bytes;
}

std::string binaryPly(bool bigEndian) {
    std::string bytes = std::string("ply\nformat binary_") + (bigEndian ? "big" : "little") +
                        "_endian 1.0\ncomment by hand\nelement vertex 4\nproperty double x\n"
                        "property uchar red\nproperty double y\nproperty double z\n"
                        "element face 4\nproperty list ushort short vertex_index\nproperty float quality\n"
                        "element edge 1\nproperty list uchar float weights\nend_header\n";
    for (const auto& corner : sampleCorners) {
        append(bytes, static_cast<double>(corner[0]), bigEndian);
        append(bytes, std::uint8_t{200});
        append(bytes, static_cast<double>(corner[1]), bigEndian);
        append(bytes, static_cast<double>(corner[2]), bigEndian);
    }
    for (const auto& face : faces) {
        append(bytes, std::uint16_t{3}, bigEndian);
        for (const int corner : face) append(bytes, static_cast<std::int16_t>(corner), bigEndian);
        append(bytes, 0.5F, bigEndian);
    }
    append(bytes, std::uint8_t{1});
    append(bytes, 1.0F, bigEndian);
    return bytes;
}

std::vector<SampleFile> tetrahedronFiles() {
    const std::string obj =
        "# a comment\nmtllib nothing.mtl\no one\nv 0 0 0 1\nv 1 0 0\nv 0 1 0\nv 0 0 1e0\nvt 0 0\nvn 0 0 1\ng "
        "a\n"
        "f 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4//1\ns off\ng b\nf -4 \\\n -1 -2\nf 2/1 3/1 4/1\n";
    const std::string off =
        "OFF # a comment\n\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3 255 0 0\n3 0 3 2\n3 1 2 3\n";
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    // Every second triangle of a strip is turned round: 0 2 1, 1 2 3; then 2 0 3, 3 0 1.
    const std::string strips =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n0 0 1\n10 0 2 1 3 -1 2 0 3 1 -1\n";
    return {{"tetrahedron.obj", obj},
            {"tetrahedron.off", off},
            {"tetrahedron.ply", ply},
            {"little.ply", binaryPly(false)},
            {"big.ply", binaryPly(true)},
            {"ascii.stl", asciiStl()},
            {"binary.stl", binaryStl("binary", triangles())},
            {"trap.stl", binaryStl("solid, but binary", triangles())},
            {"tetrahedron.obj.gz", gzipped(obj)},
            {"big.ply.gz", gzipped(binaryPly(true))},
            {"strips.ply", strips}};
}

Result<prep::ReadMesh> readBytes(const SampleFile& file, std::uint64_t limit) {
    const TempDir folder;
    const auto path = folder / file.name;
    std::ofstream(path, std::ios::binary) << file.bytes;
    QuietProgress progress;
    return prep::readMesh(path, limit, progress);
}

double enclosedVolume(const prep::TriangleMesh& mesh) {
    double volume = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        volume += glm::dot(glm::dvec3(mesh.positions[a]),
                           glm::cross(glm::dvec3(mesh.positions[b]), glm::dvec3(mesh.positions[c]))) /
                  6.0;
    }
    return volume;
}

}  // namespace mote::test
