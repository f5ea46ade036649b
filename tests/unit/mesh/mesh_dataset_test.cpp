// SPDX-License-Identifier: GPL-3.0-or-later
//
// A mesh on disk: what comes back is what was written, and damage is found.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/surface_topology.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/mesh/surface_mesh.h"
#include "storage/verify.h"
#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/mesh/sample_files.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

class MeshDataset : public testing::Test {
  protected:
    void SetUp() override {
        const auto sample = tetrahedronFiles().front();
        std::ofstream(input_) << sample.bytes;
        proto::JobRequest request;
        request.mutable_mesh()->set_input(input_.string());
        const auto made = must(prep::runMeshJob(request, input_, dataset_, {}, progress_));
    }

    TempDir folder_;
    fs::path input_ = folder_ / "tetrahedron.obj";
    fs::path dataset_ = folder_ / "a.mote";
    QuietProgress progress_;
};

TEST_F(MeshDataset, ComesBackAsItWas) {
    const auto manifest = must(storage::readManifest(dataset_));
    EXPECT_EQ(manifest.kind(), "mesh");
    EXPECT_EQ(manifest.request().mesh().input(), "tetrahedron.obj");
    // Three right triangles of area 1/2 and the slanted one, sqrt(3) / 2; from 32-bit corners, summed as
    // doubles.
    EXPECT_NEAR(manifest.mesh().area(), 1.5 + std::sqrt(3.0) / 2.0, 1e-14);
    const auto mesh = must(storage::readMesh(dataset_, manifest));
    const auto wanted = prep::makeSurfaceMesh(readBytes(tetrahedronFiles().front())->mesh);
    EXPECT_EQ(mesh.positions, wanted.positions);
    EXPECT_EQ(mesh.normals, wanted.normals);
    EXPECT_EQ(mesh.triangles, wanted.triangles);
    EXPECT_EQ(mesh.edges, wanted.edges);
    EXPECT_EQ(mesh.parts, wanted.parts);
    EXPECT_THAT(storage::verifyDataset(dataset_), IsEmpty());
}

TEST_F(MeshDataset, DamageIsFound) {
    const auto manifest = *storage::readManifest(dataset_);
    {
        std::fstream file(dataset_ / "mesh.h5", std::ios::binary | std::ios::in | std::ios::out);
        file.seekp(-20, std::ios::end);
        file.write("damaged", 7);
    }
    const auto mesh = storage::readMesh(dataset_, manifest);
    ASSERT_FALSE(mesh.ok());
    EXPECT_EQ(mesh.error().code, ErrorCode::corrupt);
    EXPECT_THAT(mesh.error().where, HasSubstr("mesh.h5:/mesh/"));
    EXPECT_FALSE(storage::verifyDataset(dataset_).empty());
    fs::resize_file(dataset_ / "mesh.h5", 100);
    EXPECT_EQ(storage::readMesh(dataset_, manifest).error().code, ErrorCode::corrupt);
}

TEST_F(MeshDataset, AManifestThatLiesIsRefused) {
    auto manifest = *storage::readManifest(dataset_);
    manifest.mutable_mesh()->set_triangles(5);
    EXPECT_EQ(storage::readMesh(dataset_, manifest).error().code, ErrorCode::corrupt);
    EXPECT_TRUE(storage::checkManifest(manifest).ok());
    manifest.mutable_mesh()->set_area(-1.0);
    EXPECT_EQ(storage::checkManifest(manifest).error().where, "mesh.area");
    manifest.clear_mesh();
    EXPECT_EQ(storage::checkManifest(manifest).error().code, ErrorCode::unsupported);
    EXPECT_EQ(storage::readMesh(dataset_, manifest).error().code, ErrorCode::invalidArgument);
}

TEST_F(MeshDataset, AFailedJobLeavesNothing) {
    std::ofstream(folder_ / "bad.obj") << "v 0 0 0\nf 1 2 3\n";
    proto::JobRequest request;
    EXPECT_FALSE(prep::runMeshJob(request, folder_ / "bad.obj", folder_ / "b.mote", {}, progress_).ok());
    QuietProgress cancelling(0);
    EXPECT_EQ(prep::runMeshJob(request, input_, folder_ / "b.mote", {}, cancelling).error().code,
              ErrorCode::cancelled);
    const auto entries = std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
    EXPECT_EQ(entries, 3) << "the two inputs and the first dataset";
}

// Files cut short at every byte and changed at random: whatever comes of them is a mesh whose indices are in
// range, or an Error that names the file; never a crash, a hang, or a great deal of memory.

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

// Places that are numbers, but absurd ones: no ray begins there.

TEST(MeshPlaces, AnAbsurdPlaceIsRefused) {
    storage::SurfaceMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.triangles = {{0, 1, 2}};
    for (const float far : {1e38F, -1e38F, 2e18F, std::numeric_limits<float>::quiet_NaN()}) {
        mesh.positions[1].x = far;
        const auto checked = storage::checkSurfaceMesh(mesh);
        ASSERT_FALSE(checked.ok()) << far;
        EXPECT_EQ(checked.error().where, "/mesh/position");
        EXPECT_THAT(checked.error().message, testing::HasSubstr("beyond 1e18"));
    }
    mesh.positions[1].x = 1e18F;
    EXPECT_TRUE(storage::checkSurfaceMesh(mesh).ok());
}

TEST(MeshPlaces, AJobLeavesOutWhatTheServerWouldRefuse) {
    prep::TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e30F, 0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 3, 2}};
    prep::MeshCounts counts;
    const auto welded = prep::weldMesh(std::move(mesh), counts);
    EXPECT_EQ(welded.triangles.size(), 1U);
    EXPECT_EQ(counts.notFinite, 1U);
}

using testing::AllOf;

class MeshFormats : public testing::TestWithParam<SampleFile> {};

TEST_P(MeshFormats, ReadsTheTetrahedron) {
    const auto read = must(readBytes(GetParam()));
    EXPECT_EQ(read.mesh.positions.size(), 4U);
    EXPECT_EQ(read.mesh.triangles.size(), 4U);
    EXPECT_DOUBLE_EQ(enclosedVolume(read.mesh), 1.0 / 6.0);
}

INSTANTIATE_TEST_SUITE_P(All, MeshFormats, testing::ValuesIn(tetrahedronFiles()), [](const auto& sample) {
    auto name = sample.param.name;
    std::replace(name.begin(), name.end(), '.', '_');
    return name;
});

Error errorOf(const SampleFile& file) {
    const auto read = readBytes(file);
    return read.ok() ? Error{ErrorCode::internal, "", "was read"} : read.error();
}

TEST(MeshErrors, NameFileAndLine) {
    const auto where = [](const SampleFile& file) { return errorOf(file).toString(); };
    EXPECT_THAT(where({"a.obj", "v 0 0 0\nv 0 0\n"}), HasSubstr("a.obj: line 2"));
    EXPECT_THAT(where({"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"}),
                AllOf(HasSubstr("line 4"), HasSubstr("vertex 4 of 3")));
    EXPECT_THAT(where({"a.obj", "v 0 0 0\nf 1 2 0\n"}), HasSubstr("line 2"));
    EXPECT_THAT(where({"a.obj", "v 0 0 0\nf -2 1 1\n"}), HasSubstr("line 2"));
    EXPECT_THAT(where({"a.obj", "v 0 0 0\nf 99999999999999999999 1 1\n"}), HasSubstr("line 2"));
    EXPECT_THAT(where({"a.off", "OFF\n4000000000 1 0\n0 0 0\n"}), HasSubstr("line 2"));
    EXPECT_THAT(where({"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 7\n"}), HasSubstr("line 4"));
    EXPECT_THAT(where({"a.off", "OFF\n1 1 0\n0 0 0\n1000000000 0 0 0\n"}), HasSubstr("fewer"));
    EXPECT_THAT(where({"a.stl", "solid\nfacet normal 0 0 1\nvertex 0 0 x\n"}), HasSubstr("line 3"));
    EXPECT_THAT(where({"a.ply", "ply\nformat ascii 1.0\nelement vertex -1\n"}), HasSubstr("line 3"));
    EXPECT_THAT(where({"a.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1000000\nproperty float x\n"
                       "end_header\n0 0 0\n"}),
                HasSubstr("bytes follow"));
    EXPECT_THAT(where({"a.obj", ""}), HasSubstr("has no triangles"));
    EXPECT_EQ(errorOf({"a.dat", "0 1 2 3\n"}).code, ErrorCode::unsupported);
    EXPECT_EQ(errorOf({"points.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                       "property float y\nproperty float z\nend_header\n0 0 0\n"})
                  .code,
              ErrorCode::unsupported);
    EXPECT_THAT(where({"a.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                       "property float y\nproperty float z\nelement face 1\n"
                       "property list uint int vertex_indices\nend_header\n0 0 0\n4000000000 0\n"}),
                HasSubstr("does not fit the file"));
}

TEST(MeshErrors, ABinaryFileThatPromisesTooMuchIsRefusedBeforeMemoryIsTaken) {
    std::string stl(80, 'x');
    stl += "\xff\xff\xff\xff";
    stl += std::string(100, '\0');
    EXPECT_THAT(errorOf({"a.stl", stl}).toString(), AllOf(HasSubstr("byte 80"), HasSubstr("for 2")));
}

TEST(MeshErrors, WhatIsInflatedIsBounded) {
    // 64 MiB of blanks become 64 KiB.
    const auto bomb = gzipped(std::string(64 << 20, ' '));
    EXPECT_LT(bomb.size(), 100U << 10);
    const auto read = readBytes({"bomb.obj.gz", bomb}, 16 << 20);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(read.error().message, HasSubstr("16 MiB"));
}

TEST(MeshErrors, ACancelledReadStops) {
    const TempDir folder;
    QuietProgress progress(0);
    EXPECT_EQ(prep::readMesh(folder / "none.obj", 1, progress).error().code, ErrorCode::notFound);
}

TEST(Polygons, KeepTheirShapeWhereTheyAreNotConvex) {
    // An arrowhead, whose fan from the first corner would cover what it does not; area 1 by the shoelace.
    const std::string arrow = "v 0 2 0\nv -1 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3 4\n";
    const auto read = readBytes({"arrow.obj", arrow});
    ASSERT_TRUE(read.ok());
    double area = 0.0;
    for (const auto& [a, b, c] : read->mesh.triangles) {
        const auto& p = read->mesh.positions;
        const double twice = (p[b].x - p[a].x) * (p[c].y - p[a].y) - (p[c].x - p[a].x) * (p[b].y - p[a].y);
        EXPECT_GT(twice, 0.0);
        area += twice / 2.0;
    }
    EXPECT_DOUBLE_EQ(area, 1.0);
}

TEST(Polygons, OfAnyNumberOfCornersEnd) {
    for (const int corners : {3, 5, 64, 65, 5000}) {
        std::string text;
        std::string face = "f";
        for (int i = 0; i < corners; ++i) {
            const double angle = 6.283185307179586 * i / corners;
            text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
            face += " " + std::to_string(i + 1);
        }
        const auto read = must(readBytes({"ring.obj", text + face + "\n"}));
        EXPECT_EQ(read.counts.triangles, static_cast<std::uint64_t>(corners) - 2);
    }
}

// A star, concave at every other corner: a fan would cover it many times over.
TEST(Polygons, OfManyCornersKeepTheirShape) {
    for (const int corners : {66, 1000}) {
        std::string text, face = "f";
        for (int i = 0; i < corners; ++i) {
            const double angle = 6.283185307179586 * i / corners, radius = i % 2 == 0 ? 1.0 : 0.4;
            text += fmt::format("v 0 {} {}\n", radius * std::cos(angle), radius * std::sin(angle));
            face += fmt::format(" {}", i + 1);
        }
        const auto read = must(readBytes({"star.obj", text + face + "\n"}));
        double area = 0.0;
        for (const auto& [a, b, c] : read.mesh.triangles) {
            const auto& p = read.mesh.positions;
            area += 0.5 * glm::length(glm::cross(glm::dvec3(p[b]) - glm::dvec3(p[a]),
                                                 glm::dvec3(p[c]) - glm::dvec3(p[a])));
        }
        // corners triangles of sides 1 and .4 with an angle between.
        EXPECT_NEAR(area, 0.5 * corners * 0.4 * std::sin(6.283185307179586 / corners), 1e-6);
        EXPECT_EQ(read.counts.tangled, 0U);
    }
}

TEST(Polygons, ThatWindIntoThemselvesAreCutAllTheSame) {
    std::string text, face = "f";
    for (int i = 0; i < 501; ++i) {
        text += fmt::format("v {} {} 0\n", i * 7919 % 501, i * 104729 % 499);
        face += fmt::format(" {}", i + 1);
    }
    const auto read = must(readBytes({"knot.obj", text + face + "\n"}));
    EXPECT_EQ(read.counts.triangles, 499U);
    EXPECT_EQ(read.counts.tangled, 1U);
}

// 4 m in UTM coordinates, where the step of a float is half a metre.
TEST(FarMeshes, KeepTheirShapeAndSayWhatWasTakenOff) {
    const std::string text =
        "v 448123.25 5450321.5 100\nv 448127.25 5450321.5 100\nv 448127.25 5450325.5 100\nf 1 2 3\n";
    const auto read = must(readBytes({"utm.obj", text}));
    EXPECT_EQ(read.mesh.origin, glm::dvec3(448125, 5450324, 100));
    const auto& p = read.mesh.positions;
    EXPECT_EQ(p[0], glm::vec3(-1.75F, -2.5F, 0.0F));
    EXPECT_EQ(p[2], glm::vec3(2.25F, 1.5F, 0.0F));
    EXPECT_THAT(prep::describeOrigin(read.mesh.origin), HasSubstr("(448125, 5450324, 100) was taken off"));
    EXPECT_EQ(prep::originFor({20, 0, 0}, {24, 4, 4}), glm::dvec3(0)) << "floats do there";
}

TEST(Welding, CountsAndRepairs) {
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv nan 0 0\nv 0.5 0 0\nv 9 9 9\nv 1e39 0 0\nv 0.5 1e-5 0\n"
        "f 1 2 3\nf 4 2 3\nf 1 4 2\nf 1 2 6\nf 1 2 5\nf 1 2 8\nf 1 2 9\nf 3 2 1\n";
    const auto read = must(readBytes({"bad.obj", text}));
    EXPECT_EQ(read.mesh.triangles.size(), 2U);
    EXPECT_EQ(read.counts.vertices, 9U);
    EXPECT_EQ(read.counts.triangles, 8U);
    EXPECT_EQ(read.counts.duplicates, 1U);
    EXPECT_EQ(read.counts.degenerate, 2U);
    EXPECT_EQ(read.counts.notFinite, 2U);
    EXPECT_EQ(read.counts.repeated, 2U) << "the one over the duplicate and the one turned round";
    EXPECT_EQ(read.counts.needles, 1U);
    EXPECT_EQ(read.mesh.positions.size(), 4U);
    EXPECT_THAT(prep::describeRepairs(read.counts), HasSubstr("2 triangles without area"));
}

// Meshes that other people's programs wrote, against the counts that are known of them.

namespace fs = std::filesystem;

struct Known {
    const char* file;
    std::uint64_t vertices;
    std::uint64_t triangles;
};

class RealMeshes : public testing::TestWithParam<Known> {};

TEST_P(RealMeshes, HaveTheirTriangles) {
    const auto path = fs::path(MOTE_SHARED_DATA) / "meshes" / GetParam().file;
    if (!fs::exists(path)) GTEST_SKIP() << "the real file is not here";
    QuietProgress progress;
    const auto read = must(prep::readMesh(path, std::uint64_t{1} << 30, progress));
    EXPECT_EQ(read.counts.vertices, GetParam().vertices);
    EXPECT_EQ(read.counts.triangles, GetParam().triangles);
    EXPECT_LE(read.counts.degenerate + read.counts.repeated, GetParam().triangles / 20);
    const auto mesh = prep::makeSurfaceMesh(read.mesh);
    EXPECT_TRUE(storage::checkSurfaceMesh(mesh).ok());
    EXPECT_GE(2 * mesh.edges.size(), 3 * mesh.triangles.size());
}

INSTANTIATE_TEST_SUITE_P(All, RealMeshes,
                         testing::Values(Known{"teapot.obj", 3644, 6320}, Known{"skull.obj", 49999, 100002},
                                         Known{"nefertiti_lowres.obj", 35002, 70000},
                                         Known{"spot.obj", 11533, 23062},
                                         Known{"tree_white_birch.obj.gz", 140124, 178908},
                                         Known{"tree_small_pine.obj.gz", 219088, 142382},
                                         Known{"ct_bones_spine_pelvis.ply.gz", 92517, 184170}),
                         [](const auto& sample) {
                             std::string name = sample.param.file;
                             return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace mote::test
