// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/dataset_content.h"

#include <span>
#include <utility>
#include <vector>

#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/mapped_step.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "tests/support/must.h"

namespace mote::test {
namespace {

using storage::StorageError;

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

/// What a picture may take that waits for nothing.
void askWhatIsReady(const storage::ParticleStep& step) {
    const bool all = step.octreeReady() && step.volumeReady();
    const auto points = step.positionsReady(0, step.pointCount());
    if (all && points > 0) step.positions(0, points);
    step.preview(step.previewReady(storage::Preview::mostPoints));
}

void addStep(const std::filesystem::path& dataset, const proto::Manifest& manifest, std::uint32_t index,
             const std::shared_ptr<storage::BlockBudget>& budget, Content& content) {
    const auto step = must(storage::ParticleStep::open(dataset, manifest, index, budget));
    askWhatIsReady(*step);
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
    askWhatIsReady(*step);
    if (manifest.particles().steps(static_cast<int>(index)).columns_file().empty()) return;
    const auto columns = must(storage::ParticleColumns::open(dataset, manifest, index, budget));
    for (std::size_t c = 0; c < columns->columns().size(); ++c)
        if (columns->columns()[c].doubles)
            content.add(columns->doubles(c, 0, columns->pointCount()));
        else
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
            const auto found = render::hybridParts(hybrid, asked);
            if (!found.ok()) continue;  // it has no such representation
            const auto parts = *found;
            // The bytes as the server counts them against its memory, before anything is read.
            if (render::hybridBytes(hybrid, step, parts) + render::hybridLoadingBytes(hybrid, step, parts) >
                mostSampleBytes) {
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

std::string contentOfDataset(const std::filesystem::path& dataset,
                             std::shared_ptr<storage::BlockBudget> budget) {
    const auto manifest = must(storage::readManifest(dataset));
    Content content;
    for (int i = 0; i < manifest.particles().steps_size(); ++i)
        addStep(dataset, manifest, static_cast<std::uint32_t>(i), budget, content);
    if (manifest.has_hybrid()) addHybrid(dataset, manifest, content);
    if (manifest.has_stipple()) addHierarchy(must(storage::readHierarchy(dataset, manifest)), content);
    if (manifest.has_mesh()) addMesh(must(storage::readMesh(dataset, manifest)), content);
    if (manifest.has_image()) {
        content.add(must(storage::readImage(dataset, manifest)).values);
        content.add(must(storage::readColors(dataset, manifest)).values);
    }
    auto described = manifest;
    described.clear_files();  // their hashes are those of what is compared anyway
    return described.SerializeAsString() + content.take();
}

}  // namespace mote::test
