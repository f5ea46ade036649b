// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/sample_datasets.h"

#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <span>

#include "storage/arrays/array_file.h"
#include "storage/dataset_writer.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/step_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/storage_error.h"
#include "tests/support/ball_surface.h"
#include "tests/support/must.h"
#include "tests/support/random.h"
#include "tests/unit/hybrid/small_hybrid.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::test {
namespace {

constexpr std::uint32_t writtenLeaf = 16, maxLevel = 8;

MemoryRun::Step cloudStep(Random& random, std::uint64_t count, std::uint8_t volumeLevel) {
    std::vector<WeightedPoint> points;
    for (std::uint64_t i = 0; i < count; ++i) {
        const double scale = random.chance(0.5) ? 0.05 : 1.0;
        points.push_back({scale * glm::dvec3(random.unit(), random.unit(), random.unit()), 1.0});
    }
    MemoryRun::Step step;
    step.points = MemoryStep::make(
        points, {.leafCapacity = writtenLeaf, .maxLevel = maxLevel, .volumeLevel = volumeLevel});
    std::vector<MemoryColumns::Column> columns{{{"x", "m", 0.5}, {}},
                                               {{"y", "m", 0.5}, {}},
                                               {{"z", "m", 0.5}, {}},
                                               {{"px", "eV/c", 0.0}, {}},
                                               {{"weight", "1", 1.0}, {}}};
    std::vector<std::uint64_t> ids;
    for (const auto row : step.points->rows(0, count)) {
        for (int axis = 0; axis < 3; ++axis)
            columns[static_cast<std::size_t>(axis)].values.push_back(
                static_cast<float>(points[row].position[axis] - 0.5));
        columns[3].values.push_back(static_cast<float>(random.between(-1.0, 1.0)));
        columns[4].values.push_back(static_cast<float>(random.between(-0.5, 0.5)));
        ids.push_back(3 * row);
    }
    step.columns = std::make_shared<const MemoryColumns>(count, std::move(columns), std::move(ids));
    return step;
}

void writePoints(const std::filesystem::path& directory, const std::string& name, const MemoryStep& step) {
    storage::StepContent content;
    content.axes = {"x", "y", "z"};
    content.boundsMax = {1.0, 1.0, 1.0};
    content.totalWeight = static_cast<double>(step.pointCount());
    content.nodes = step.nodes();
    content.leaves = step.leaves();
    content.positions = step.positions(0, step.pointCount());
    content.rows = step.rows(0, step.pointCount());
    content.volume = step.volume();
    content.volumeSize = step.volumeSize();
    const auto preview = step.preview(storage::Preview::mostPoints);
    content.previewPoints = preview.points;
    content.previewThreshold = preview.threshold;
    must(storage::writeStep(directory, name, content));
}

void writeColumns(const std::filesystem::path& directory, const std::string& name,
                  const MemoryColumns& columns) {
    const auto points = columns.pointCount();
    const auto file = must(storage::ArrayFileWriter::create(
        directory, name, storage::columnsLayout(columns.columns(), true, points)));
    const auto count = columns.columns().size();
    for (std::size_t c = 0; c < count; ++c)
        must(file.write(c, 0, std::as_bytes(columns.values(c, 0, points))));
    must(file.write(count, 0, std::as_bytes(columns.ids(0, points))));
    must(file.write(count + 1, 0, std::as_bytes(columns.pointsById(0, points))));
    must(file.finish());
}

void describeStep(const MemoryRun::Step& step, const std::string& points, const std::string& columns,
                  proto::ParticleStepEntry& entry) {
    entry.set_file(points + ".h5");
    entry.set_digest(points + ".digest");
    entry.set_columns_file(columns + ".h5");
    entry.set_columns_digest(columns + ".digest");
    entry.set_total_weight(static_cast<double>(step.points->pointCount()));
    for (const auto& column : step.columns->columns()) entry.add_column_offset(column.offset);
    for (int bin = 0; bin < storage::densityHistogramBins; ++bin)
        entry.add_density_histogram(bin == 0 ? step.points->pointCount() : 0);
}

}  // namespace

std::shared_ptr<const MemoryRun> cloudRun(std::uint64_t seed, std::uint64_t points, std::uint32_t steps,
                                          std::uint8_t volumeLevel) {
    Random random(seed, 151);
    std::vector<MemoryRun::Step> all;
    for (std::uint32_t i = 0; i < steps; ++i) all.push_back(cloudStep(random, points, volumeLevel));
    return std::make_shared<const MemoryRun>(std::move(all), BeamContext{});
}

void writeRun(const MemoryRun& run, const std::filesystem::path& output) {
    auto writer = must(storage::DatasetWriter::create(output));
    proto::Manifest manifest;
    manifest.set_kind("particles");
    manifest.set_format(storage::formatVersion);
    auto& particles = *manifest.mutable_particles();
    particles = run.manifest();
    for (const char* name : {"x", "y", "z"}) {
        auto& axis = *particles.add_axes();
        axis.set_name(name);
        axis.set_max(1.0);
    }
    const auto& first = *run.at(0).points;
    particles.set_density_min(first.logDensity().min);
    particles.set_density_max(first.logDensity().max);
    particles.set_volume_level(static_cast<std::uint32_t>(std::countr_zero(first.volumeSize())));
    particles.set_leaf_capacity(writtenLeaf);
    particles.set_max_level(maxLevel);
    for (int i = 0; i < particles.steps_size(); ++i) {
        const auto index = static_cast<std::uint32_t>(i);
        const auto points = storage::stepName(index), columns = storage::columnsName(index);
        writePoints(writer.directory(), points, *run.at(index).points);
        writeColumns(writer.directory(), columns, *run.at(index).columns);
        for (const auto& name : {points, columns}) {
            must(writer.add(name + ".h5"));
            must(writer.add(name + ".digest"));
        }
        describeStep(run.at(index), points, columns, *particles.mutable_steps(i));
    }
    must(writer.publish(manifest));
}

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
    std::vector<std::uint16_t> colors;
    for (std::uint32_t i = 0; i < 3 * width * height; ++i)
        colors.push_back(storage::halfBits(static_cast<float>(i % 61) / 45.0F));
    must(storage::writeImage(writer.directory(), picture, colors));
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
    return {"{'dataset': 'plane', 'stipple': {'image': 'sample'}}", "{'dataset': 'sample', 'image': {}}"};
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
