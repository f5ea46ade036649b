// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which part of a mesh its triangles belong to: from a file's groups, objects and materials through all that
// is done to the mesh into a dataset, and back; and datasets that tell it wrongly.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <map>

#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/surface_topology.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "storage/arrays/array_file.h"
#include "storage/dataset_writer.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
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

}  // namespace
}  // namespace mote::test
