// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include "preprocess/export_grids.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/grid_axis.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"

namespace mote::prep {
namespace {

using storage::GridSize;

openvdb::FloatGrid::Ptr emptyGrid(const std::string& name, const proto::Manifest& manifest,
                                  std::uint32_t step, const GridSize& size) {
    const auto& hybrid = manifest.hybrid();
    auto grid = openvdb::FloatGrid::create(0.0F);
    grid->setName(name);
    grid->setTransform(storage::vdbTransform(
        storage::gridToWorld(storage::indexToWorld(hybrid), storage::gridSize(hybrid.source_size()), size)));
    grid->insertMeta("mote_title", openvdb::StringMetadata(manifest.title()));
    grid->insertMeta("mote_index", openvdb::Int32Metadata(static_cast<std::int32_t>(step)));
    grid->insertMeta("mote_value_unit", openvdb::StringMetadata(hybrid.value_unit()));
    grid->insertMeta("mote_world_unit", openvdb::StringMetadata(hybrid.world_unit()));
    return grid;
}

/// All samples are active: none is taken for what lies outside.
void fillLow(const storage::HybridStep& file, const proto::HybridStepEntry& entry, openvdb::FloatGrid& grid) {
    const auto& size = file.lowSize();
    const openvdb::Coord end(static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2]));
    grid.denseFill(openvdb::CoordBBox({0, 0, 0}, end.offsetBy(-1)), 0.0F);
    std::visit(
        [&](auto codes) {
            for (auto value = grid.beginValueOn(); value; ++value) {
                const auto at = value.getCoord();
                const auto index =
                    (static_cast<std::size_t>(at.z()) * size[1] + static_cast<std::size_t>(at.y())) *
                        size[0] +
                    static_cast<std::size_t>(at.x());
                value.setValue(static_cast<float>(entry.value_min() + codes[index] * entry.value_step()));
            }
        },
        file.low());
}

Status fillResidual(const std::filesystem::path& dataset, const proto::Manifest& manifest, std::uint32_t step,
                    openvdb::FloatGrid& grid) {
    auto accessor = grid.getAccessor();
    return storage::readResidual(dataset, manifest, step, [&](const storage::ResidualBrick& brick) {
        constexpr auto side = storage::residualBrickSide;
        for (std::uint32_t i = 0; i < brick.values.size(); ++i) {
            if (brick.values[i] == 0.0F) continue;
            const openvdb::Coord at(static_cast<int>(brick.index[0] * side + i % side),
                                    static_cast<int>(brick.index[1] * side + i / side % side),
                                    static_cast<int>(brick.index[2] * side + i / side / side));
            accessor.setValueOn(at, brick.values[i]);
        }
    });
}

}  // namespace

Result<VdbGrids> hybridGrids(const std::filesystem::path& dataset, const proto::Manifest& manifest,
                             std::uint32_t step) {
    MOTE_ASSIGN_OR_RETURN(const auto file, storage::HybridStep::open(dataset, manifest, step));
    openvdb::initialize();
    const auto& hybrid = manifest.hybrid();
    const auto& entry = *storage::findHybridStep(manifest, step);
    VdbGrids grids;
    const auto low = emptyGrid("volume", manifest, step, file.lowSize());
    fillLow(file, entry, *low);
    MOTE_RETURN_IF_ERROR(file.check());
    low->addStatsMetadata();
    grids.push_back(low);
    if (!hybrid.residual()) return grids;
    const auto residual = emptyGrid("residual", manifest, step, storage::gridSize(hybrid.error_size()));
    MOTE_RETURN_IF_ERROR(fillResidual(dataset, manifest, step, *residual));
    residual->addStatsMetadata();
    grids.push_back(residual);
    return grids;
}

}  // namespace mote::prep
