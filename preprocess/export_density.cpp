// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include "preprocess/export_grids.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {
namespace {

openvdb::FloatGrid::Ptr makeGrid(const storage::ParticleStep& step) {
    const int size = static_cast<int>(step.volumeSize());
    const auto volume = step.volume();
    using Dense = openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ>;
    const openvdb::CoordBBox box({0, 0, 0}, {size - 1, size - 1, size - 1});
    const Dense dense(box, volume.data());
    auto grid = openvdb::FloatGrid::create(0.0F);
    openvdb::tools::copyFromDense(dense, *grid, 0.0F);
    auto transform = openvdb::math::Transform::createLinearTransform(2.0 / size);
    transform->postTranslate(openvdb::Vec3d(-1.0 + 1.0 / size));
    grid->setTransform(transform);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

void addMetadata(const proto::Manifest& manifest, std::uint32_t step, openvdb::FloatGrid& grid) {
    const auto& particles = manifest.particles();
    for (int a = 0; a < 3; ++a) {
        const auto& axis = particles.axes(a);
        const auto prefix = fmt::format("mote_axis_{}_", "xyz"[a]);
        grid.insertMeta(prefix + "name", openvdb::StringMetadata(axis.name()));
        grid.insertMeta(prefix + "unit", openvdb::StringMetadata(axis.unit()));
        grid.insertMeta(prefix + "min", openvdb::DoubleMetadata(axis.min()));
        grid.insertMeta(prefix + "max", openvdb::DoubleMetadata(axis.max()));
    }
    grid.insertMeta("mote_title", openvdb::StringMetadata(manifest.title()));
    grid.insertMeta("mote_step", openvdb::Int32Metadata(static_cast<std::int32_t>(step)));
}

}  // namespace

Result<VdbGrids> densityGrids(const std::filesystem::path& dataset, const proto::Manifest& manifest,
                              std::uint32_t step) {
    MOTE_ASSIGN_OR_RETURN(const auto opened, storage::ParticleStep::open(dataset, manifest, step));
    openvdb::initialize();
    const auto grid = makeGrid(*opened);
    addMetadata(manifest, step, *grid);
    grid->addStatsMetadata();
    return VdbGrids{grid};
}

}  // namespace mote::prep
