// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/sample_datasets.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "storage/dataset_writer.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/storage_error.h"
#include "tests/unit/damage/written_run.h"
#include "tests/unit/hybrid/small_hybrid.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::test {
namespace {

using storage::StorageError;

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

}  // namespace mote::test
