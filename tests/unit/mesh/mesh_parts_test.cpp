// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which part of a mesh its triangles belong to: from a file's groups, objects and materials through all that
// is done to the mesh into a dataset, and back; and datasets that tell it wrongly.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>

#include "preprocess/mesh/find_intersections.h"
#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/surface_topology.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "storage/arrays/array_file.h"
#include "storage/dataset_writer.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/mesh/triangle_intersection.h"
#include "storage/verify.h"
#include "tests/support/must.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/mesh/sample_files.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Three corners that no other number's triangle has.
std::string corners(std::size_t number) {
    return fmt::format("v {0} 0 0\nv {0} 1 0\nv {0} 0 1\n", number);
}

storage::SurfaceMesh meshOf(const std::string& obj) {
    const auto read = readBytes({"parts.obj", obj});
    EXPECT_TRUE(read.ok()) << read.error().toString();
    return read.ok() ? prep::makeSurfaceMesh(read->mesh) : storage::SurfaceMesh();
}

std::vector<std::uint32_t> partsOf(const std::string& obj) {
    return meshOf(obj).parts;
}

TEST(ObjParts, AreCombinationsOfGroupObjectAndMaterial) {
    Random random(3);
    for (int round = 0; round < 40; ++round) {
        std::map<std::string, std::string> current{{"g", ""}, {"o", ""}, {"usemtl", ""}};
        std::map<std::map<std::string, std::string>, std::uint32_t> numbers;
        std::vector<std::uint32_t> wanted;
        std::string text;
        for (std::size_t i = 0; i < 60; ++i) {
            for (auto& [key, name] : current) {
                if (!random.chance(0.2)) continue;
                name = random.oneOf<std::string>({"", "a", "b", "a b", "leaf-7"});
                text += key + ' ' + name + '\n';
            }
            text += corners(i) + "f -3 -2 -1\n";
            const auto next = static_cast<std::uint32_t>(numbers.size());
            wanted.push_back(numbers.try_emplace(current, next).first->second);
        }
        EXPECT_EQ(partsOf(text), wanted) << text;
    }
}

TEST(ObjParts, ThereAreNoneWhereAllAreOne) {
    EXPECT_THAT(partsOf(corners(0) + corners(1) + "f 1 2 3\nf 4 5 6\n"), IsEmpty());
    EXPECT_THAT(partsOf("g a\nusemtl b\n" + corners(0) + corners(1) + "f 1 2 3\nusemtl b\nf 4 5 6\ng c\n"),
                IsEmpty());
    EXPECT_THAT(partsOf(corners(0) + corners(1) + "f 1 2 3\ng default\nf 4 5 6\ng\n"), IsEmpty());
    for (const auto& file : tetrahedronFiles()) {
        const bool obj = file.name.find(".obj") != std::string::npos;
        EXPECT_EQ(prep::makeSurfaceMesh(readBytes(file)->mesh).parts.empty(), !obj) << file.name;
    }
}

TEST(ObjParts, NamesMayGoOnInTheNextLineAndFacesStandBeforeTheirVertices) {
    const std::string vertices = corners(0) + corners(1) + corners(2) + corners(3);
    EXPECT_THAT(partsOf(vertices + "g a \\\nb\nf 1 2 3\ng a  b # c\nf 4 5 6\ng a\nf 7 8 9\n"),
                ElementsAre(0, 0, 1));
    std::string far = "g a";
    for (int i = 0; i < 300000; ++i) far += " \\\n";
    EXPECT_THAT(partsOf(vertices + far + " b\nf 1 2 3\ng a b\nf 4 5 6\ng a\nf 7 8 9\n"),
                ElementsAre(0, 0, 1));
    // Those that wait come last.
    EXPECT_THAT(partsOf(corners(0) + "g a\nf 10 11 12\ng b\nf 1 2 3\n" + corners(1) + "f 4 5 6\ng a\n" +
                        corners(2) + "f 7 8 9\n" + corners(3)),
                ElementsAre(0, 0, 1, 1));
}

TEST(ObjParts, PolygonsAreOfOnePartAndWhatIsLeftOutHasNone) {
    const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n";
    EXPECT_THAT(partsOf(square + "g a\nf 1 2 3 4\ng b\nf 2 5 6 3\n"), ElementsAre(0, 0, 1, 1));
    // One without area, and the first triangle again.
    EXPECT_THAT(
        partsOf(square + "g flat\nf 1 2 5\ng a\nf 1 2 3\ng again\nf 2 3 1\ng b\nf 2 5 6\ng a\nf 2 6 3\n"),
        ElementsAre(0, 1, 0));
    EXPECT_THAT(partsOf(square + "g flat\nf 1 2 5\ng a\nf 1 2 3\n"), IsEmpty());
}

TEST(ObjParts, MayBeAsManyAsTriangles) {
    std::string text;
    constexpr std::uint32_t many = 20000;
    for (std::uint32_t i = 0; i < many; ++i)
        text += fmt::format("o leaf{}\nusemtl m{}\n{}f -3 -2 -1\n", i, i % 7, corners(i));
    const auto parts = partsOf(text);
    ASSERT_EQ(parts.size(), many);
    for (std::uint32_t i = 0; i < many; ++i) ASSERT_EQ(parts[i], i);
}

TEST(MeshParts, StayWithTheirTrianglesInAnyOrder) {
    Random random(4);
    prep::TriangleMesh mesh;
    std::map<prep::Triangle, std::uint32_t> part;
    for (std::uint32_t i = 0; i < 500; ++i) {
        const glm::vec3 at(random.between(0.0, 1.0), random.between(0.0, 1.0), random.between(0.0, 1.0));
        mesh.positions.insert(mesh.positions.end(),
                              {at, at + glm::vec3(0.1F, 0, 0), at + glm::vec3(0, 0.1F, 0)});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        mesh.parts.push_back(i * 7919 % 13);
        part[mesh.triangles.back()] = mesh.parts.back();
    }
    const auto before = mesh.triangles;
    prep::orderInSpace(mesh);
    EXPECT_NE(mesh.triangles, before);
    ASSERT_EQ(mesh.parts.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        EXPECT_EQ(mesh.parts[i], part.at(mesh.triangles[i]));
    const auto made = prep::makeSurfaceMesh(mesh);
    EXPECT_TRUE(storage::checkSurfaceMesh(made).ok());
    EXPECT_EQ(*std::max_element(made.parts.begin(), made.parts.end()), 12U);
}

class PartDataset : public testing::Test {
  protected:
    /// A dataset of this mesh, right or wrong.
    void write(const storage::SurfaceMesh& mesh) {
        auto writer = storage::DatasetWriter::create(dataset_);
        ASSERT_TRUE(writer.ok());
        ASSERT_TRUE(storage::writeMesh(writer->directory(), mesh).ok());
        ASSERT_TRUE(writer->add("mesh.h5").ok());
        ASSERT_TRUE(writer->add("mesh.digest").ok());
        proto::Manifest manifest;
        manifest.set_kind("mesh");
        manifest.set_format(storage::formatVersion);
        *manifest.mutable_mesh() = storage::describeMesh(mesh);
        must(writer->publish(manifest));
    }
    Result<storage::SurfaceMesh> read() {
        return storage::readMesh(dataset_, *storage::readManifest(dataset_));
    }

    TempDir folder_;
    fs::path dataset_ = folder_ / "a.mote";
    const storage::SurfaceMesh mesh_ =
        meshOf(corners(0) + corners(1) + corners(2) + "g a\nf 1 2 3\ng b\nf 4 5 6\ng a\nf 7 8 9\n");
};

TEST_F(PartDataset, IsMadeByTheJobAndComesBack) {
    const auto input = folder_ / "parts.obj";
    std::ofstream(input) << corners(0) + corners(1) + "usemtl a\nf 1 2 3\nusemtl b\nf 4 5 6\n";
    proto::JobRequest request;
    request.mutable_mesh()->set_input(input.string());
    QuietProgress progress;
    ASSERT_TRUE(prep::runMeshJob(request, input, dataset_, {}, progress).ok());
    const auto mesh = must(read());
    EXPECT_THAT(mesh.parts, ElementsAre(0, 1));
    EXPECT_THAT(storage::verifyDataset(dataset_), IsEmpty());
}

TEST_F(PartDataset, HasNoneInItsFileWhereAllAreOne) {
    auto mesh = mesh_;
    mesh.parts.clear();
    write(mesh);
    const auto file = storage::ArrayFile::open(dataset_, *storage::readManifest(dataset_), storage::meshName);
    ASSERT_TRUE(file.ok());
    EXPECT_FALSE(file->has("/mesh/part"));
    EXPECT_THAT(read()->parts, IsEmpty());
}

TEST_F(PartDataset, OfWrongLengthIsRefused) {
    auto mesh = mesh_;
    ASSERT_THAT(mesh.parts, ElementsAre(0, 1, 0));
    mesh.parts.pop_back();
    write(mesh);
    const auto found = read();
    ASSERT_FALSE(found.ok());
    EXPECT_EQ(found.error().code, ErrorCode::corrupt);
    EXPECT_THAT(found.error().toString(), AllOf(HasSubstr("mesh.h5:/mesh/part"), HasSubstr("[2], not [3]")));
    EXPECT_FALSE(storage::verifyDataset(dataset_).empty());
}

TEST_F(PartDataset, WithANumberThatIsNotNextIsRefused) {
    for (const auto& parts : {std::vector<std::uint32_t>{0, 2, 1}, {1, 0, 0}, {0, 0, 4294967295U}}) {
        auto mesh = mesh_;
        mesh.parts = parts;
        write(mesh);
        const auto found = read();
        ASSERT_FALSE(found.ok());
        EXPECT_EQ(found.error().code, ErrorCode::corrupt);
        EXPECT_THAT(found.error().toString(), AllOf(HasSubstr("mesh.h5:/mesh/part"), HasSubstr("number")));
        EXPECT_FALSE(storage::verifyDataset(dataset_).empty());
        fs::remove_all(dataset_);
    }
}

// Which triangles of a mesh cut each other: held to a trial of all pairs by
// other means, and to what bodies have in common.

using CutPairs = std::vector<std::array<std::uint32_t, 2>>;

/// Bodies in one mesh; corners in one place are one corner, as welding leaves
/// them.
class Bodies {
  public:
    void add(const std::vector<glm::dvec3>& places, const std::vector<prep::Triangle>& triangles) {
        std::vector<std::uint32_t> numbers;
        for (const auto& place : places) {
            const glm::vec3 at(place);
            const auto known = std::find(mesh_.positions.begin(), mesh_.positions.end(), at);
            numbers.push_back(static_cast<std::uint32_t>(known - mesh_.positions.begin()));
            if (known == mesh_.positions.end()) mesh_.positions.push_back(at);
        }
        for (const auto& [a, b, c] : triangles)
            mesh_.triangles.push_back({numbers[a], numbers[b], numbers[c]});
    }
    void addBox(const glm::dvec3& low, const glm::dvec3& high) {
        std::vector<glm::dvec3> corners;
        for (int i = 0; i < 8; ++i)
            corners.emplace_back((i & 4) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                                 (i & 1) != 0 ? high.z : low.z);
        add(corners, {{0, 1, 3},
                      {0, 3, 2},
                      {4, 6, 7},
                      {4, 7, 5},
                      {0, 4, 5},
                      {0, 5, 1},
                      {2, 3, 7},
                      {2, 7, 6},
                      {0, 2, 6},
                      {0, 6, 4},
                      {1, 5, 7},
                      {1, 7, 3}});
    }
    void addFloor(double z, bool turned = false) {
        const std::vector<glm::dvec3> corners{{-5, -5, z}, {5, -5, z}, {5, 5, z}, {-5, 5, z}};
        if (turned)
            add(corners, {{0, 2, 1}, {0, 3, 2}});
        else
            add(corners, {{0, 1, 2}, {0, 2, 3}});
    }
    /// Rings of corners around the z axis, at each of some heights.
    void addTube(const std::vector<double>& heights, std::uint32_t around) {
        std::vector<glm::dvec3> places;
        std::vector<prep::Triangle> triangles;
        for (std::uint32_t ring = 0; ring < heights.size(); ++ring) {
            for (std::uint32_t i = 0; i < around; ++i) {
                const double turn = 2.0 * std::numbers::pi * i / around;
                places.emplace_back(std::cos(turn), std::sin(turn), heights[ring]);
                const std::uint32_t a = ring * around + i, b = ring * around + (i + 1) % around;
                if (ring + 1 == heights.size()) continue;
                triangles.push_back({a, b, b + around});
                triangles.push_back({a, b + around, a + around});
            }
        }
        add(places, triangles);
    }
    /// A leaning plane of so many squares.
    void addSheet(std::uint32_t squares, double aside) {
        std::vector<glm::dvec3> places;
        std::vector<prep::Triangle> triangles;
        for (std::uint32_t row = 0; row <= squares; ++row) {
            for (std::uint32_t column = 0; column <= squares; ++column) {
                const double x = static_cast<double>(column) / squares,
                             y = static_cast<double>(row) / squares;
                places.emplace_back(x + aside, y + aside, 0.37 * x + 0.21 * y + aside);
                const std::uint32_t i = row * (squares + 1) + column, above = i + squares + 1;
                if (row == squares || column == squares) continue;
                triangles.push_back({i, i + 1, above + 1});
                triangles.push_back({i, above + 1, above});
            }
        }
        add(places, triangles);
    }
    storage::SurfaceMesh made() const { return prep::makeSurfaceMesh(mesh_); }

  private:
    prep::TriangleMesh mesh_;
};

CutPairs cutPairsOf(const storage::SurfaceMesh& mesh) {
    const auto pairs = prep::findIntersections(mesh, [] { return false; });
    EXPECT_TRUE(pairs.has_value());
    return pairs.value_or(CutPairs());
}

double cutLengthOf(const storage::SurfaceMesh& mesh) {
    const storage::TriangleIntersections rule(mesh);
    double length = 0.0;
    for (const auto& [one, other] : cutPairsOf(mesh)) {
        const auto ends = rule.between(one, other);
        EXPECT_TRUE(ends.has_value());
        if (ends) length += glm::distance((*ends)[0], (*ends)[1]);
    }
    return length;
}

TEST(FindIntersections, ABoxInTheFloorHasALineAroundIt) {
    for (const bool turned : {false, true}) {
        Bodies bodies;
        bodies.addFloor(0.3, turned);
        bodies.addBox({0, 0, 0.1}, {1, 2, 1});
        EXPECT_NEAR(cutLengthOf(bodies.made()), 6.0, 1e-6);
    }
}

TEST(FindIntersections, WhatStandsOnItOrHangsBelowHasNone) {
    for (const bool turned : {false, true}) {
        Bodies bodies;
        bodies.addFloor(0.3, turned);
        bodies.addBox({-3, 0, 0.3}, {-2, 2, 1.3});
        bodies.addBox({2, 0, -0.7}, {3, 2, 0.3});
        bodies.addTube({0.3, 1.3}, 24);
        EXPECT_TRUE(cutPairsOf(bodies.made()).empty());
    }
}

/// Also of a mesh whose floor is not one of the numbers that a float has.
TEST(FindIntersections, ATubeWithARingInTheFloorGoesThroughIt) {
    constexpr int around = 24;
    for (const double z : {0.0, 0.3, 0.1 + 0.2, 1.0 / 3.0}) {
        Bodies bodies;
        bodies.addFloor(z);
        bodies.addTube({z - 1.0, z, z + 1.0}, around);
        EXPECT_NEAR(cutLengthOf(bodies.made()), 2.0 * around * std::sin(std::numbers::pi / around), 1e-5);
    }
}

TEST(FindIntersections, AWholeSurfaceAndPartsInOnePlaneHaveNone) {
    for (const double aside : {0.0, 100.0}) {
        Bodies bodies;
        bodies.addSheet(13, aside);
        bodies.addSheet(17, aside);
        EXPECT_TRUE(cutPairsOf(bodies.made()).empty()) << aside;
    }
    Bodies tube;
    tube.addTube({0.0, 0.5, 1.0, 2.0}, 40);
    EXPECT_TRUE(cutPairsOf(tube.made()).empty());
}

/// Whether a side of one triangle goes through the other, by volumes of
/// tetrahedra.
bool pierces(const storage::SurfaceMesh& mesh, std::uint32_t one, std::uint32_t other) {
    const auto at = [&](std::uint32_t triangle, std::size_t corner) {
        return glm::dvec3(mesh.positions[mesh.triangles[triangle][corner % 3]]);
    };
    const auto volume = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                           const glm::dvec3& d) { return glm::dot(glm::cross(b - a, c - a), d - a); };
    for (std::size_t i = 0; i < 3; ++i) {
        const auto p = at(one, i), q = at(one, i + 1), a = at(other, 0), b = at(other, 1), c = at(other, 2);
        if ((volume(a, b, c, p) > 0.0) == (volume(a, b, c, q) > 0.0)) continue;
        const bool side = volume(p, q, a, b) > 0.0;
        if ((volume(p, q, b, c) > 0.0) == side && (volume(p, q, c, a) > 0.0) == side) return true;
    }
    return false;
}

TEST(FindIntersections, AreThosePairsThatATrialOfAllFinds) {
    Random random(5);
    for (int round = 0; round < 4; ++round) {
        prep::TriangleMesh mesh;
        for (std::uint32_t i = 0; i < 300; ++i) {
            const glm::dvec3 middle(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
            for (int corner = 0; corner < 3; ++corner)
                mesh.positions.emplace_back(middle + random.oneOf({0.1, 0.5, 1.0}) * random.direction());
            mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
        const auto made = prep::makeSurfaceMesh(mesh);
        CutPairs wanted;
        for (std::uint32_t i = 0; i < 300; ++i) {
            for (std::uint32_t k = i + 1; k < 300; ++k) {
                if (pierces(made, i, k) || pierces(made, k, i)) wanted.push_back({i, k});
            }
        }
        EXPECT_GT(wanted.size(), 300U);
        EXPECT_EQ(cutPairsOf(made), wanted);
    }
}

TEST(FindIntersections, LinesOfNeighboursHaveTheSameEnds) {
    Bodies bodies;
    bodies.addTube({-1.0, -0.2, 0.9, 2.0}, 24);
    bodies.addBox({-2, -0.4, -0.3}, {2, 0.5, 0.6});
    const auto mesh = bodies.made();
    const storage::TriangleIntersections rule(mesh);
    std::multiset<std::array<double, 3>> ends;
    for (const auto& [one, other] : cutPairsOf(mesh)) {
        const auto line = rule.between(one, other);
        ASSERT_TRUE(line.has_value());
        for (const auto& at : *line) ends.insert({at.x, at.y, at.z});
    }
    ASSERT_FALSE(ends.empty());
    for (const auto& at : ends) EXPECT_EQ(ends.count(at), 2U) << "lines around a body are closed";
}

/// So many sheets through as many others.
std::string tangleOf(int sheets) {
    std::string obj;
    for (int i = 0; i < 2 * sheets; ++i) {
        const double at = (i / 2) / static_cast<double>(sheets);
        for (const auto& [a, b] : {std::pair(-9, -9), std::pair(9, -9), std::pair(0, 18)})
            obj += i % 2 == 0 ? fmt::format("v {} {} {}\n", at, a, b) : fmt::format("v {} {} {}\n", a, at, b);
        obj += "f -3 -2 -1\n";
    }
    return obj;
}

Result<storage::SurfaceMesh> cutDatasetOf(const std::string& obj, proto::Manifest& manifest) {
    const TempDir folder;
    std::ofstream(folder / "a.obj") << obj;
    QuietProgress progress;
    MOTE_ASSIGN_OR_RETURN(manifest, prep::runMeshJob({}, folder / "a.obj", folder / "a.mote", {}, progress));
    EXPECT_TRUE(storage::verifyDataset(folder / "a.mote").empty());
    return storage::readMesh(folder / "a.mote", manifest);
}

/// Two triangles of one plane, which another one cuts.
TEST(FindIntersections, ADatasetKeepsThem) {
    proto::Manifest manifest;
    auto mesh = cutDatasetOf(
        "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1 1 2\nv 3 3 0.5\nv 1 0 0\nv 0 3 0\nf 1 2 3\nf 7 2 8\nf 6 5 "
        "4\n",
        manifest);
    ASSERT_TRUE(mesh.ok()) << mesh.error().toString();
    EXPECT_EQ(mesh->intersections, (CutPairs{{0, 2}, {1, 2}}));
    mesh->intersections.push_back({1, 3});
    EXPECT_EQ(storage::checkSurfaceMesh(*mesh).error().where, "/mesh/intersection");
}

TEST(FindIntersections, ThatAreTooManyAreANote) {
    proto::Manifest manifest;
    const auto mesh = cutDatasetOf(tangleOf(2100), manifest);
    ASSERT_TRUE(mesh.ok()) << mesh.error().toString();
    EXPECT_TRUE(mesh->intersections.empty());
    const auto& notes = manifest.mesh().notes();
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
        return note.find("no lines are drawn there") != std::string::npos;
    }));
}

TEST(FindIntersections, TheSearchEndsWhereItIsCancelled) {
    const auto made = prep::makeSurfaceMesh(readBytes({"a.obj", tangleOf(300)})->mesh);
    int asked = 0;
    EXPECT_FALSE(prep::findIntersections(made, [&] { return ++asked == 1; }).has_value());
    EXPECT_EQ(asked, 1);
}

}  // namespace
}  // namespace mote::test
