// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/stipple/small_hierarchy.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "storage/dataset_writer.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/storage_error.h"

namespace mote::test {
namespace {

void require(const Status& status) {
    if (!status.ok()) throw storage::StorageError(status.error());
}

}  // namespace

storage::StippleHierarchy smallHierarchy() {
    storage::StippleHierarchy h;
    for (int i = 0; i < 5; ++i) h.positions.push_back({0.1F + 0.2F * static_cast<float>(i), 0.0F, 0.0F});
    h.normals.assign(5, {0.0F, 0.0F, 1.0F});
    h.removal = {1, 3, 0, 4, 2};
    h.deathArea = {0.25F, 0.5F, 0.2F, 1.0F, 0.33F};
    h.locked.assign(5, 0);
    h.movesBegin = {0, 0, 3, 3, 5, 5};
    h.moveNeighbour = {2, 0, 4, 2, 1};
    h.movePosition = {
        {0.4F, 0.0F, 0.0F}, {0.4F, 0.1F, 0.0F}, {0.5F, 0.1F, 0.0F}, {0.6F, 0, 0}, {0.6F, 0.1F, 0}};
    return h;
}

storage::StippleHierarchy jitteredGrid(int side) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(0.2F, 0.8F);
    storage::StippleHierarchy h;
    const auto step = 1.0F / static_cast<float>(side);
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            const float left = (static_cast<float>(x) + unit(random)) * step;
            h.positions.push_back({left, (static_cast<float>(y) + unit(random)) * step, 0.0F});
        }
    }
    h.normals.assign(h.size(), {0.0F, 0.0F, 1.0F});
    h.removal.resize(h.size());
    std::iota(h.removal.begin(), h.removal.end(), 0U);
    std::shuffle(h.removal.begin(), h.removal.end(), random);
    h.deathArea.assign(h.size(), 1.0F);
    h.locked.assign(h.size(), 0);
    h.movesBegin.assign(h.size() + 1, 0);
    return h;
}

proto::Manifest manifestOf(const storage::StippleHierarchy& hierarchy) {
    proto::Manifest manifest;
    manifest.set_kind("stipple");
    manifest.set_format(1);
    auto& stipple = *manifest.mutable_stipple();
    stipple.set_domain(proto::StippleManifest::PLANE);
    stipple.set_points(hierarchy.size());
    stipple.set_moves(hierarchy.moveNeighbour.size());
    stipple.set_area(1.0);
    stipple.set_rings(2);
    stipple.set_relaxation(1.6);
    return manifest;
}

void writeDataset(const std::filesystem::path& output, const storage::StippleHierarchy& hierarchy,
                  const proto::Manifest& manifest) {
    auto writer = storage::DatasetWriter::create(output);
    if (!writer.ok()) throw storage::StorageError(writer.error());
    require(storage::writeHierarchy(writer->directory(), hierarchy));
    require(writer->add("hierarchy.h5"));
    require(writer->add("hierarchy.digest"));
    require(writer->publish(manifest));
}

}  // namespace mote::test
