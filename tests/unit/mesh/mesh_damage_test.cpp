// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files cut short at every byte and changed at random: whatever comes of them is a mesh whose indices are in
// range, or an Error that names the file; never a crash, a hang, or a great deal of memory.
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "tests/unit/mesh/sample_files.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

using Parse = Result<prep::TriangleMesh> (*)(std::string_view, const std::string&);

Parse parserOf(const std::string& name) {
    if (name.find("obj") != std::string::npos) return prep::parseObj;
    if (name.find("off") != std::string::npos) return prep::parseOff;
    return name.find("ply") != std::string::npos ? prep::parsePly : prep::parseStl;
}

void expectSound(const SampleFile& file, const std::string& bytes) {
    auto parsed = parserOf(file.name)(bytes, file.name);
    if (!parsed.ok()) {
        EXPECT_THAT(parsed.error().where, HasSubstr(file.name));
        EXPECT_FALSE(parsed.error().message.empty());
        return;
    }
    for (const auto& triangle : parsed->triangles) {
        for (const auto corner : triangle) ASSERT_LT(corner, parsed->positions.size());
    }
    prep::MeshCounts counts;
    const auto welded = prep::weldMesh(*std::move(parsed), counts);
    EXPECT_TRUE(welded.parts.empty() || welded.parts.size() == welded.triangles.size());
    for (const auto& position : welded.positions) {
        ASSERT_TRUE(std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z));
    }
}

class MeshDamage : public testing::TestWithParam<SampleFile> {};

TEST_P(MeshDamage, CutShortAnywhere) {
    const auto& file = GetParam();
    for (std::size_t size = 0; size < file.bytes.size(); ++size) {
        expectSound(file, file.bytes.substr(0, size));
    }
}

TEST_P(MeshDamage, BytesChanged) {
    const auto& file = GetParam();
    std::mt19937 random(7);
    for (int round = 0; round < 20000; ++round) {
        auto bytes = file.bytes;
        const auto changes = 1 + random() % 4;
        for (std::size_t i = 0; i < changes; ++i) {
            const auto at = random() % bytes.size();
            switch (random() % 4) {
                case 0:
                    bytes[at] = static_cast<char>(random());
                    break;
                case 1:
                    bytes[at] = "0123456789-+.eE \n"[random() % 17];
                    break;
                case 2:
                    bytes.erase(at, 1 + random() % 8);
                    if (bytes.empty()) bytes = " ";
                    break;
                default:
                    bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 16));
            }
        }
        expectSound(file, bytes);
    }
}

std::vector<SampleFile> plainFiles() {
    auto files = tetrahedronFiles();
    std::erase_if(files, [](const auto& file) { return file.name.ends_with(".gz"); });
    return files;
}

INSTANTIATE_TEST_SUITE_P(All, MeshDamage, testing::ValuesIn(plainFiles()), [](const auto& sample) {
    auto name = sample.param.name;
    std::replace(name.begin(), name.end(), '.', '_');
    return name;
});

TEST(GzipDamage, CutShortOrChanged) {
    for (const auto& file : tetrahedronFiles()) {
        if (!file.name.ends_with(".gz")) continue;
        for (std::size_t size = 0; size < file.bytes.size(); size += 7) {
            const auto read = readBytes({file.name, file.bytes.substr(0, size)});
            ASSERT_FALSE(read.ok());
            EXPECT_THAT(read.error().where, HasSubstr(file.name));
        }
    }
}

}  // namespace
}  // namespace mote::test
