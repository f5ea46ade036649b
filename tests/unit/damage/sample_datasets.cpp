// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/sample_datasets.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "storage/dataset_writer.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "tests/support/ball_surface.h"
#include "tests/support/must.h"
#include "tests/unit/damage/written_run.h"
#include "tests/unit/hybrid/small_hybrid.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::test {
namespace {

storage::DatasetWriter writerOf(const std::filesystem::path& output) {
    return must(storage::DatasetWriter::create(output));
}

/// Takes in the files of these names, and publishes.
void publish(storage::DatasetWriter& writer, std::initializer_list<const char*> names,
             const proto::Manifest& manifest) {
    for (const std::string name : names) {
        must(writer.add(name + ".h5"));
        must(writer.add(name + ".digest"));
    }
    must(writer.publish(manifest));
}

storage::SurfaceMesh tetrahedron() {
    storage::SurfaceMesh mesh;
    mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (const auto& position : mesh.positions) mesh.normals.push_back(glm::normalize(position));
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    mesh.edges = {{{0, 1}, {0, 1}}, {{1, 2}, {0, 3}}, {{2, 0}, {0, 2}},
                  {{0, 3}, {1, 2}}, {{3, 1}, {1, 3}}, {{2, 3}, {2, 3}}};
    mesh.parts = {0, 0, 1, 1};
    return mesh;
}

void writeParticles(const std::filesystem::path& output) {
    writeRun(*cloudRun(1, 80, 1, 2), output);
}

void writeHybrid(const std::filesystem::path& output) {
    writeSmallHybrid(output, smallPoints(5), smallManifest(5, 8));
}

void writeFlatHybrid(const std::filesystem::path& output) {
    writeSmallHybrid(output, smallPoints(9), smallManifest(9, 16));
}

void writePlane(const std::filesystem::path& output) {
    const auto hierarchy = smallHierarchy();
    writeDataset(output, hierarchy, manifestOf(hierarchy));
}

void writeSurface(const std::filesystem::path& output) {
    const auto hierarchy = smallHierarchy();
    auto manifest = manifestOf(hierarchy);
    manifest.mutable_stipple()->set_domain(proto::StippleManifest::SURFACE);
    *manifest.mutable_mesh() = storage::describeMesh(tetrahedron());
    auto writer = writerOf(output);
    must(storage::writeHierarchy(writer.directory(), hierarchy));
    must(storage::writeMesh(writer.directory(), tetrahedron()));
    publish(writer, {storage::hierarchyName, storage::meshName}, manifest);
}

void writeMeshDataset(const std::filesystem::path& output) {
    proto::Manifest manifest;
    manifest.set_kind("mesh");
    manifest.set_format(storage::formatVersion);
    *manifest.mutable_mesh() = storage::describeMesh(tetrahedron());
    auto writer = writerOf(output);
    must(storage::writeMesh(writer.directory(), tetrahedron()));
    publish(writer, {storage::meshName}, manifest);
}

void writeImage(const std::filesystem::path& output, std::uint32_t width, std::uint32_t height) {
    storage::Luminance picture{width, height, {}};
    for (std::uint32_t i = 0; i < width * height; ++i)
        picture.values.push_back(static_cast<float>(i % 64) / 50.0F);
    proto::Manifest manifest;
    manifest.set_kind("image");
    manifest.set_format(storage::formatVersion);
    manifest.mutable_image()->set_width(picture.width);
    manifest.mutable_image()->set_height(picture.height);
    auto writer = writerOf(output);
    must(storage::writeImage(writer.directory(), picture));
    publish(writer, {storage::imageName}, manifest);
}

void writePicture(const std::filesystem::path& output) {
    writeImage(output, 9, 7);
}

void writeLargeParticles(const std::filesystem::path& output) {
    writeRun(*cloudRun(2, 60000, 1, 5), output);
}

/// A coarse grid of 64^3, and a point at each sample of 8 x 4 x 4 bricks.
void writeLargeHybrid(const std::filesystem::path& output) {
    constexpr storage::GridSize low{64, 64, 64}, errors{128, 128, 128}, told{64, 32, 32};
    constexpr std::uint32_t pointBytes = 6;
    auto manifest = smallManifest(pointBytes, 8);
    auto& hybrid = *manifest.mutable_hybrid();
    for (int axis = 0; axis < 3; ++axis) {
        hybrid.set_low_size(axis, low[0]);
        hybrid.set_error_size(axis, errors[0]);
    }
    hybrid.set_residual(false);
    const auto count = storage::samplesOf(told);
    hybrid.mutable_steps(0)->set_points(count);
    hybrid.mutable_steps(0)->clear_residual_file();
    SmallPoints points;
    for (std::uint64_t i = 0; i < count; ++i) {
        for (const auto place : {i % told[0], i / told[0] % told[1], i / told[0] / told[1]})
            points.place8.push_back(static_cast<std::uint8_t>(place));
    }
    points.value.assign(count, 200);
    points.error.assign(count, 140);
    points.normal.assign(count, 3);
    auto view = points.view();
    view.grid = errors;
    auto writer = writerOf(output);
    const auto file = must(storage::HybridStepWriter::create(writer.directory(), "step-000000",
                                                             {low, 8, pointBytes, errors, count}));
    std::vector<std::uint8_t> codes(storage::samplesOf(low));
    for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint8_t>(i % 251);
    must(file.writeLow(std::span<const std::uint8_t>(codes), codes));
    must(file.writePoints(0, view));
    must(file.finish());
    publish(writer, {"step-000000"}, manifest);
}

void writeLargePlane(const std::filesystem::path& output) {
    const auto hierarchy = jitteredGrid(150);
    writeDataset(output, hierarchy, manifestOf(hierarchy));
}

void writeLargeSurface(const std::filesystem::path& output) {
    writeBall(output, 20000);
}

void writeLargePicture(const std::filesystem::path& output) {
    writeImage(output, 700, 600);
}

std::vector<std::string> particleLayers() {
    return {"{'dataset': 'sample', 'particles': {}}",
            "{'dataset': 'sample', 'particles': {}, 'colorBy': {'column': 'px'}}",
            "{'dataset': 'sample', 'particles': {}, 'select': {'ranges': [{'column': 'x', 'min': 0.05}]}, "
            "'highlight': {'selection': {'density': {'min': 0.3}}}}",
            "{'dataset': 'sample', 'particles': {}, 'paths': {'ids': [3, 30, 60]}, "
            "'colorBy': {'column': 'y', 'range': [-1, 1], 'ofPixel': 'nearest'}}",
            "{'dataset': 'sample', 'ink': {}}"};
}

std::vector<std::string> hybridLayers() {
    return {"{'dataset': 'sample', 'hybrid': {}}",
            "{'dataset': 'sample', 'hybrid': {'representation': 'points'}}",
            "{'dataset': 'sample', 'hybrid': {'representation': 'volume'}}",
            "{'dataset': 'sample', 'ink': {}}"};
}

std::vector<std::string> meshLayers() {
    return {"{'dataset': 'sample', 'mesh': {}}", "{'dataset': 'sample', 'ink': {}}"};
}

std::vector<std::string> planeLayers() {
    return {"{'dataset': 'sample', 'stipple': {'image': 'picture'}}"};
}

std::vector<std::string> surfaceLayers() {
    return {"{'dataset': 'sample', 'stipple': {}}"};
}

std::vector<std::string> pictureLayers() {
    return {"{'dataset': 'plane', 'stipple': {'image': 'sample'}}"};
}

}  // namespace

const std::vector<SampleDataset>& sampleDatasets() {
    static const std::vector<SampleDataset> all{
        {.name = "particles", .write = writeParticles, .layers = particleLayers(), .counted = true},
        {"hybrid", writeHybrid, hybridLayers()},
        {"hybridOfFlatPoints", writeFlatHybrid, hybridLayers()},
        {"stippledPlane", writePlane, planeLayers()},
        {"stippledSurface", writeSurface, surfaceLayers()},
        {"mesh", writeMeshDataset, meshLayers()},
        {"image", writePicture, pictureLayers()}};
    return all;
}

const std::vector<SampleDataset>& largeDatasets() {
    static const std::vector<SampleDataset> all{{.name = "largeParticles",
                                                 .write = writeLargeParticles,
                                                 .layers = particleLayers(),
                                                 .large = true,
                                                 .counted = true},
                                                {"largeHybrid", writeLargeHybrid, hybridLayers(), true},
                                                {"largePlane", writeLargePlane, planeLayers(), true},
                                                {"largeSurface", writeLargeSurface, surfaceLayers(), true},
                                                {"largeMesh", writeBallMesh, meshLayers(), true},
                                                {"largeImage", writeLargePicture, pictureLayers(), true}};
    return all;
}

void writeCompanions(const std::filesystem::path& folder) {
    writePicture(folder / "picture.mote");
    writePlane(folder / "plane.mote");
}

}  // namespace mote::test
