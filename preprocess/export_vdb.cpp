// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/export_vdb.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <unistd.h>

#include "storage/particles/particle_step.h"
#include "storage/vdb/vdb_file.h"
#include "storage/write_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// A file beside its final place, removed unless it got there.
class PartialFile {
  public:
    explicit PartialFile(const fs::path& output) : path_(output) {
        path_ += fmt::format(".partial-{}", ::getpid());
    }
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;
    ~PartialFile() { ::unlink(path_.c_str()); }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

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

Status exportVdb(const fs::path& dataset, const proto::Manifest& manifest, std::uint32_t step,
                 const fs::path& output) {
    std::error_code code;
    if (fs::exists(fs::symlink_status(output, code))) {
        return Error{ErrorCode::alreadyExists, output.string(), "exists already and is never replaced"};
    }
    const auto opened = storage::ParticleStep::open(dataset, manifest, step);
    if (!opened.ok()) return opened.error();
    openvdb::initialize();
    const auto grid = makeGrid(**opened);
    addMetadata(manifest, step, *grid);
    const PartialFile partial(output);
    MOTE_RETURN_IF_ERROR(storage::writeVdbFile(partial.path(), {grid}));
    MOTE_RETURN_IF_ERROR(storage::syncPath(partial.path()));
    return storage::publishByRename(partial.path(), output);
}

}  // namespace mote::prep
