// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/export_vdb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "preprocess/draft_file.h"
#include "protocol/quantity/plot_axes.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/residual_file.h"
#include "storage/particles/particle_step.h"
#include "storage/vdb/vdb_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

using storage::FloatGrid;
using storage::GridSize;
using Grids = std::vector<FloatGrid>;

/// Voxel (i, j, k) is the cell with that index along the three axes, the box is [-1, 1]^3.
glm::dmat4 cellsToLayer(std::uint32_t size) {
    const double side = 2.0 / size;
    glm::dmat4 matrix(side);
    matrix[3] = glm::dvec4(glm::dvec3(-1.0 + 1.0 / size), 1.0);
    return matrix;
}

void noteAxes(const proto::ParticlesManifest& particles, std::uint32_t step, const FloatGrid& grid) {
    for (int a = 0; a < 3; ++a) {
        const auto& axis = axisOf(particles, a, step);
        const auto prefix = fmt::format("mote_axis_{}_", "xyz"[a]);
        grid.note(prefix + "name", axis.name());
        grid.note(prefix + "unit", axis.unit());
        grid.note(prefix + "min", axis.min());
        grid.note(prefix + "max", axis.max());
    }
}

Result<Grids> densityGrids(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step) {
    MOTE_ASSIGN_OR_RETURN(const auto opened, storage::ParticleStep::open(dataset, manifest, step));
    const auto size = opened->volumeSize();
    const FloatGrid grid("density", cellsToLayer(size));
    grid.fillNonzero({size, size, size}, opened->volume());
    grid.setFog();
    noteAxes(manifest.particles(), step, grid);
    grid.note("mote_title", manifest.title());
    grid.note("mote_step", static_cast<std::int32_t>(step));
    grid.noteSamples();
    return Grids{grid};
}

FloatGrid emptyGrid(const std::string& name, const proto::Manifest& manifest, std::uint32_t step,
                    const GridSize& size) {
    const auto& hybrid = manifest.hybrid();
    FloatGrid grid(name, storage::gridToWorld(storage::indexToWorld(hybrid),
                                              storage::gridSize(hybrid.source_size()), size));
    grid.note("mote_title", manifest.title());
    grid.note("mote_index", static_cast<std::int32_t>(step));
    grid.note("mote_value_unit", hybrid.value_unit());
    grid.note("mote_world_unit", hybrid.world_unit());
    return grid;
}

/// Fills all samples; all are active: none is taken for what lies outside.
void fillLow(const storage::HybridStep& file, const proto::HybridStepEntry& entry, const FloatGrid& grid) {
    std::visit(
        [&](auto codes) {
            grid.fill(file.lowSize(), [&](std::size_t index) {
                return static_cast<float>(entry.value_min() + codes[index] * entry.value_step());
            });
        },
        file.low());
}

Status fillResidual(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step,
                    const FloatGrid& grid) {
    const auto set = grid.setter();
    return storage::readResidual(dataset, manifest, step, [&](const storage::ResidualBrick& brick) {
        constexpr auto side = storage::residualBrickSide;
        for (std::uint32_t i = 0; i < brick.values.size(); ++i) {
            if (brick.values[i] == 0.0F) continue;
            set({static_cast<int>(brick.index[0] * side + i % side),
                 static_cast<int>(brick.index[1] * side + i / side % side),
                 static_cast<int>(brick.index[2] * side + i / side / side)},
                brick.values[i]);
        }
    });
}

Result<Grids> hybridGrids(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step) {
    MOTE_ASSIGN_OR_RETURN(const auto file, storage::HybridStep::open(dataset, manifest, step));
    const auto low = emptyGrid("volume", manifest, step, file.lowSize());
    fillLow(file, *storage::findHybridStep(manifest, step), low);
    MOTE_RETURN_IF_ERROR(file.check());
    low.noteSamples();
    if (!manifest.hybrid().residual()) return Grids{low};
    const auto residual =
        emptyGrid("residual", manifest, step, storage::gridSize(manifest.hybrid().error_size()));
    MOTE_RETURN_IF_ERROR(fillResidual(dataset, manifest, step, residual));
    residual.noteSamples();
    return Grids{low, residual};
}

struct GridMaker {
    std::string_view kind;  ///< of the dataset
    std::string_view what;
    Result<Grids> (*make)(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step);
};

constexpr std::array makers{GridMaker{"particles", "density", densityGrids},
                            GridMaker{"hybrid", "volume", hybridGrids}};

}  // namespace

Result<std::string> exportVdb(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step,
                              const fs::path& output) {
    const auto* const maker = std::ranges::find(makers, manifest.kind(), &GridMaker::kind);
    if (maker == makers.end()) {
        return invalid(dataset.string(),
                       fmt::format("is a dataset of kind \"{}\", which holds no volume", manifest.kind()));
    }
    MOTE_ASSIGN_OR_RETURN(auto draft, DraftFile::create(output));
    MOTE_ASSIGN_OR_RETURN(const auto grids, maker->make(dataset, manifest, step));
    MOTE_RETURN_IF_ERROR(storage::writeVdbFile(draft.path(), grids));
    MOTE_RETURN_IF_ERROR(draft.publish());
    return std::string(maker->what);
}

}  // namespace mote::prep
