// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/vdb/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <cerrno>
#include <fstream>
#include <string>
#include <utility>

#include "protocol/base/mote_check.h"
#include "protocol/base/system_error.h"
#include "storage/hash.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

using Grid = openvdb::FloatGrid;
using Leaf = Grid::TreeType::LeafNodeType;
using Top = Grid::TreeType::RootNodeType::ChildNodeType;
static_assert(Leaf::DIM == vdbLeafSide);
static_assert(Top::ChildNodeType::DIM == vdbNodeSide && Top::DIM == vdbTopSide);

openvdb::math::Transform::Ptr linear(const glm::dmat4& indexToWorld) {
    openvdb::math::Mat4d rows;  // OpenVDB multiplies from the left: its rows are our columns
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) rows[column][row] = indexToWorld[column][row];
    }
    return openvdb::math::Transform::createLinearTransform(rows);
}

/// Makes a grid by OpenVDB's own table of kinds: its library has the code of a grid already, and Grid::create
/// would have it made here once more.
openvdb::GridBase::Ptr emptyGrid() {
    openvdb::initialize();
    return openvdb::GridBase::createGrid(Grid::gridType());
}

Grid& gridOf(const std::shared_ptr<openvdb::GridBase>& base) {
    return static_cast<Grid&>(*base);
}

openvdb::CoordBBox box(const GridSize& size) {
    const openvdb::Coord end(static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2]));
    return {openvdb::Coord(0, 0, 0), end.offsetBy(-1)};
}

/// io::File writes where it likes and looks at no stream's state; io::Archive looks into the trees of grids,
/// which need not have one in memory.
class Writer : public openvdb::io::Archive {
  public:
    void writeTo(std::ostream& out, const std::vector<FloatGrid>& grids, VdbValues values) {
        setCompression(vdbCompression(values));
        writeHeader(out, true);
        openvdb::MetaMap().writeMeta(out);
        const auto count = static_cast<std::int32_t>(grids.size());
        out.write(reinterpret_cast<const char*>(&count), sizeof(count));
        for (const auto& grid : grids) writeOne(out, *grid.base(), grid);
    }

  private:
    void writeOne(std::ostream& out, const openvdb::GridBase& grid, const FloatGrid& contents) const {
        openvdb::io::GridDescriptor descriptor(grid.getName(), grid.type(), grid.saveFloatAsHalf());
        descriptor.writeHeader(out);
        const auto places = out.tellp();
        descriptor.writeStreamPos(out);
        descriptor.setGridPos(out.tellp());
        setGridCompression(out, grid);
        grid.writeMeta(out);
        grid.writeTransform(out);
        contents.writeTopology(out);
        descriptor.setBlockPos(out.tellp());
        contents.writeValues(out);
        descriptor.setEndPos(out.tellp());
        out.seekp(places);
        descriptor.writeStreamPos(out);
        out.seekp(descriptor.getEndPos());
    }
};

/// Where an archive has its UUID: after the magic number (8 bytes), the file's version (4), the library's
/// (2 x 4) and whether there are offsets (1); 36 characters.
constexpr std::streamoff identityAt = 21;

bool writeIdentity(std::fstream& file, std::string_view identity) {
    file.seekp(identityAt);
    file.write(identity.data(), static_cast<std::streamsize>(identity.size()));
    file.flush();
    return file.good();
}

}  // namespace

FloatGrid::FloatGrid(const std::string& name, const glm::dmat4& indexToWorld, TreeWriters tree)
    : base_(emptyGrid()), tree_(std::move(tree)) {
    base_->setName(name);
    base_->setTransform(linear(indexToWorld));
}

void FloatGrid::writeTopology(std::ostream& out) const {
    return tree_.topology ? tree_.topology(out) : base_->writeTopology(out);
}

void FloatGrid::writeValues(std::ostream& out) const {
    return tree_.values ? tree_.values(out) : base_->writeBuffers(out);
}

void FloatGrid::note(const std::string& name, const std::string& text) const {
    base_->insertMeta(name, openvdb::StringMetadata(text));
}

void FloatGrid::note(const std::string& name, std::int32_t number) const {
    base_->insertMeta(name, openvdb::Int32Metadata(number));
}

void FloatGrid::note(const std::string& name, double number) const {
    base_->insertMeta(name, openvdb::DoubleMetadata(number));
}

void FloatGrid::noteSamples(const Indices& first, const Indices& last, std::int64_t count) const {
    using openvdb::GridBase;
    base_->insertMeta(GridBase::META_FILE_BBOX_MIN, openvdb::Vec3IMetadata(openvdb::Vec3i(first.data())));
    base_->insertMeta(GridBase::META_FILE_BBOX_MAX, openvdb::Vec3IMetadata(openvdb::Vec3i(last.data())));
    base_->insertMeta(GridBase::META_FILE_VOXEL_COUNT, openvdb::Int64Metadata(count));
}

void FloatGrid::noteSamples() const {
    base_->addStatsMetadata();
}

void FloatGrid::setFog() const {
    base_->setGridClass(openvdb::GRID_FOG_VOLUME);
}

void FloatGrid::setHalves(bool halves) const {
    base_->setSaveFloatAsHalf(halves);
}

void FloatGrid::fill(const GridSize& size, const std::function<float(std::size_t)>& value) const {
    auto& grid = gridOf(base_);
    grid.denseFill(box(size), 0.0F);
    for (auto sample = grid.beginValueOn(); sample; ++sample) {
        const auto at = sample.getCoord();
        const auto row = static_cast<std::size_t>(at.z()) * size[1] + static_cast<std::size_t>(at.y());
        sample.setValue(value(row * size[0] + static_cast<std::size_t>(at.x())));
    }
}

void FloatGrid::fillNonzero(const GridSize& size, std::span<const float> values) const {
    using Dense = openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ>;
    MOTE_CHECK(values.size() == std::size_t{size[0]} * size[1] * size[2]);
    openvdb::tools::copyFromDense(Dense(box(size), values.data()), gridOf(base_), 0.0F);
}

FloatGrid::SetSample FloatGrid::setter() const {
    return [accessor = gridOf(base_).getAccessor()](const Indices& at, float value) mutable {
        accessor.setValueOn({at[0], at[1], at[2]}, value);
    };
}

std::uint32_t vdbCompression(VdbValues values) {
    return (values == VdbValues::zip ? openvdb::io::COMPRESS_ZIP : openvdb::io::COMPRESS_NONE) |
           openvdb::io::COMPRESS_ACTIVE_MASK;
}

Status writeVdbFile(const fs::path& path, const std::vector<FloatGrid>& grids, VdbValues values) {
    const Error full{ErrorCode::resourceExhausted, path.string(),
                     "cannot be written whole: is the disk full?", true};
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
    if (!file.good()) return systemError(errno, path.string(), "cannot be made");
    try {
        Writer().writeTo(file, grids, values);
    } catch (const StorageError& error) {
        return error.error();
    } catch (const std::exception& error) {
        return file.good() ? Error{ErrorCode::internal, path.string(), error.what()} : full;
    }
    file.flush();
    if (!file.good() || !writeIdentity(file, "00000000-0000-0000-0000-000000000000")) return full;
    MOTE_ASSIGN_OR_RETURN(const auto hash, hashFile(path));
    const std::string_view h = hash.xxh3_128;
    const auto identity = fmt::format("{}-{}-{}-{}-{}", h.substr(0, 8), h.substr(8, 4), h.substr(12, 4),
                                      h.substr(16, 4), h.substr(20));
    return writeIdentity(file, identity) ? success() : Status(full);
}

}  // namespace mote::storage
