// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/mesh/sample_files.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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

}  // namespace
}  // namespace mote::test
