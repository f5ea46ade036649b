// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/sample_datasets.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/dataset_writer.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/mapped_step.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/storage_error.h"
#include "tests/unit/damage/written_run.h"
#include "tests/unit/hybrid/small_hybrid.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::test {
namespace {

using storage::StorageError;

constexpr std::uint64_t mostBytes = std::uint64_t{64} << 20;

template <class T>
T must(Result<T> result) {
    if (!result.ok()) throw StorageError(result.error());
    return *std::move(result);
}

void must(const Status& status) {
    if (!status.ok()) throw StorageError(status.error());
}

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
    writeRun(*cloudRun(1, 400, 1, 2), output);
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

void writePicture(const std::filesystem::path& output) {
    storage::Luminance picture{9, 7, {}};
    for (int i = 0; i < 63; ++i) picture.values.push_back(static_cast<float>(i) / 50.0F);
    proto::Manifest manifest;
    manifest.set_kind("image");
    manifest.set_format(storage::formatVersion);
    manifest.mutable_image()->set_width(picture.width);
    manifest.mutable_image()->set_height(picture.height);
    auto writer = writerOf(output);
    must(storage::writeImage(writer.directory(), picture));
    publish(writer, {storage::imageName}, manifest);
}

/// Bytes, one thing after the other.
class Content {
  public:
    template <class T>
    void add(std::span<const T> values) {
        const auto bytes = std::as_bytes(values);
        text_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    template <class T>
    void add(const std::vector<T>& values) {
        add(std::span<const T>(values));
    }
    std::string take() { return std::move(text_); }

  private:
    std::string text_;
};

void addStep(const std::filesystem::path& dataset, const proto::Manifest& manifest, std::uint32_t index,
             Content& content) {
    const auto step = must(storage::ParticleStep::open(dataset, manifest, index));
    const auto nodes = step->nodes();
    content.add(nodes.level);
    content.add(nodes.morton);
    content.add(nodes.firstChild);
    content.add(nodes.childCount);
    content.add(nodes.count);
    content.add(nodes.density);
    content.add(nodes.minDensity);
    const auto leaves = step->leaves();
    content.add(leaves.node);
    content.add(leaves.pointBegin);
    content.add(leaves.pointCount);
    content.add(leaves.density);
    content.add(step->positions(0, step->pointCount()));
    content.add(step->rows(0, step->pointCount()));
    content.add(step->volume());
    const auto preview = step->preview(storage::Preview::mostPoints);
    content.add(preview.points);
    content.add(preview.threshold);
    step->check();
    if (manifest.particles().steps(static_cast<int>(index)).columns_file().empty()) return;
    const auto columns = must(storage::ParticleColumns::open(dataset, manifest, index));
    for (std::size_t c = 0; c < columns->columns().size(); ++c)
        content.add(columns->values(c, 0, columns->pointCount()));
    for (std::uint64_t rank = 0; columns->hasIds() && rank < columns->pointCount(); ++rank)
        content.add(columns->ids(columns->pointOfRank(rank), 1));
    columns->check();
}

void addField(const render::GridField& field, Content& content) {
    content.add(field.coarse.values);
    content.add(field.coarse.normals);
    const double range[] = {field.range.low, field.range.high};
    content.add(std::span<const double>(range));
    if (!field.bricks) return;
    content.add(std::span<const std::int32_t>(field.bricks->numbers));
    content.add(std::span<const std::uint16_t>(field.bricks->values));
    content.add(std::span<const std::uint8_t>(field.bricks->normals));
}

void addHybrid(const std::filesystem::path& dataset, const proto::Manifest& manifest, Content& content) {
    const auto& hybrid = manifest.hybrid();
    for (std::uint32_t step = 0; step < static_cast<std::uint32_t>(hybrid.steps_size()); ++step) {
        for (const auto asked :
             {HybridRepresentation::volume, HybridRepresentation::points, HybridRepresentation::residual}) {
            const auto parts = must(render::hybridParts(hybrid, asked));
            // The bytes as the server counts them against its memory, before anything is read.
            if (render::hybridBytes(hybrid, step, parts) + render::hybridLoadingBytes(hybrid, step, parts) >
                mostBytes) {
                throw StorageError(Error{ErrorCode::resourceExhausted, "hybrid", "takes too much memory"});
            }
            addField(*must(render::loadHybrid(dataset, manifest, step, parts)), content);
        }
    }
}

void addHierarchy(const storage::StippleHierarchy& hierarchy, Content& content) {
    content.add(hierarchy.positions);
    content.add(hierarchy.normals);
    content.add(hierarchy.removal);
    content.add(hierarchy.deathArea);
    content.add(hierarchy.locked);
    content.add(hierarchy.movesBegin);
    content.add(hierarchy.moveNeighbour);
    content.add(hierarchy.movePosition);
}

void addMesh(const storage::SurfaceMesh& mesh, Content& content) {
    content.add(mesh.positions);
    content.add(mesh.normals);
    content.add(mesh.triangles);
    content.add(mesh.edges);
    content.add(mesh.parts);
}

}  // namespace

const std::vector<SampleDataset>& sampleDatasets() {
    static const std::vector<SampleDataset> all{{"particles", writeParticles},
                                                {"hybrid", writeHybrid},
                                                {"hybridOfFlatPoints", writeFlatHybrid},
                                                {"stippledPlane", writePlane},
                                                {"stippledSurface", writeSurface},
                                                {"mesh", writeMeshDataset},
                                                {"image", writePicture}};
    return all;
}

std::string contentOfDataset(const std::filesystem::path& dataset) {
    const auto manifest = must(storage::readManifest(dataset));
    Content content;
    for (int i = 0; i < manifest.particles().steps_size(); ++i)
        addStep(dataset, manifest, static_cast<std::uint32_t>(i), content);
    if (manifest.has_hybrid()) addHybrid(dataset, manifest, content);
    if (manifest.has_stipple()) addHierarchy(must(storage::readHierarchy(dataset, manifest)), content);
    if (manifest.has_mesh()) addMesh(must(storage::readMesh(dataset, manifest)), content);
    if (manifest.has_image()) content.add(must(storage::readImage(dataset, manifest)).values);
    return manifest.SerializeAsString() + content.take();
}

}  // namespace mote::test
