// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/storage/tiny_dataset.h"

#include "storage/dataset_writer.h"
#include "storage/particles/step_file.h"
#include "storage/storage_error.h"

namespace mote::test {
namespace {

void require(const Status& status) {
    if (!status.ok()) throw storage::StorageError(status.error());
}

}  // namespace

TinyDataset::TinyDataset() : volume(64) {
    for (std::size_t i = 0; i < points; ++i) {
        const auto number = static_cast<std::uint16_t>(i);
        position.push_back(
            {number, static_cast<std::uint16_t>(number + 1), static_cast<std::uint16_t>(number + 2)});
        row.push_back(7 * i);
    }
    for (std::uint16_t i = 0; i < 5000; ++i) preview.push_back({i, 1, 2, 3});
    for (std::size_t i = 0; i < volume.size(); ++i) volume[i] = static_cast<float>(i);
}

storage::StepContent TinyDataset::content() const {
    storage::StepContent content;
    content.axes = {"x", "px", "energy"};
    content.boundsMin = {-1.0, -2.0, 0.0};
    content.boundsMax = {1.0, 2.0, 5e6};
    content.totalWeight = 3e5;
    content.nodes = {level, morton, firstChild, childCount, count, density, minDensity};
    content.leaves = {leafNode, leafPointBegin, leafPointCount, leafDensity};
    content.positions = position;
    content.rows = row;
    content.volume = volume;
    content.volumeSize = 4;
    content.previewPoints = preview;
    content.previewThreshold = threshold;
    return content;
}

proto::Manifest TinyDataset::manifest() const {
    proto::Manifest manifest;
    manifest.set_kind("particles");
    manifest.set_format(1);
    manifest.set_title("tiny");
    auto& particles = *manifest.mutable_particles();
    for (std::size_t a = 0; a < 3; ++a) {
        auto& axis = *particles.add_axes();
        axis.set_name(content().axes[a]);
        axis.set_min(content().boundsMin[a]);
        axis.set_max(content().boundsMax[a]);
    }
    particles.set_density_min(8e5);
    particles.set_density_max(16e5);
    particles.set_volume_level(2);
    particles.set_leaf_capacity(1000000);
    particles.set_max_level(1);
    auto& step = *particles.add_steps();
    step.set_file("step-000000.h5");
    step.set_digest("step-000000.digest");
    step.set_particles(row.size());
    step.set_total_weight(3e5);
    for (int bin = 0; bin < 128; ++bin) step.add_density_histogram(bin == 0 ? row.size() : 0);
    return manifest;
}

void TinyDataset::write(const std::filesystem::path& output) const {
    auto writer = storage::DatasetWriter::create(output);
    if (!writer.ok()) throw storage::StorageError(writer.error());
    require(storage::writeStep(writer->directory(), "step-000000", content()));
    require(writer->add("step-000000.h5"));
    require(writer->add("step-000000.digest"));
    require(writer->publish(manifest()));
}

}  // namespace mote::test
