// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/vdb/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <string>

#include "storage/hash.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

/// io::File writes where it likes and looks at no stream's state; io::Archive looks into the trees of grids,
/// which need not have one in memory.
class Writer : public openvdb::io::Archive {
  public:
    void writeTo(std::ostream& out, const openvdb::GridPtrVec& grids, VdbValues values) {
        setCompression(vdbCompression(values));
        writeHeader(out, true);
        openvdb::MetaMap().writeMeta(out);
        const auto count = static_cast<std::int32_t>(grids.size());
        out.write(reinterpret_cast<const char*>(&count), sizeof(count));
        for (const auto& grid : grids) writeOne(out, *grid);
    }

  private:
    void writeOne(std::ostream& out, const openvdb::GridBase& grid) const {
        openvdb::io::GridDescriptor descriptor(grid.getName(), grid.type(), grid.saveFloatAsHalf());
        descriptor.writeHeader(out);
        const auto places = out.tellp();
        descriptor.writeStreamPos(out);
        descriptor.setGridPos(out.tellp());
        setGridCompression(out, grid);
        grid.writeMeta(out);
        grid.writeTransform(out);
        grid.writeTopology(out);
        descriptor.setBlockPos(out.tellp());
        grid.writeBuffers(out);
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

std::shared_ptr<openvdb::math::Transform> vdbTransform(const glm::dmat4& indexToWorld) {
    openvdb::math::Mat4d rows;  // OpenVDB multiplies from the left: its rows are our columns
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) rows[column][row] = indexToWorld[column][row];
    }
    return openvdb::math::Transform::createLinearTransform(rows);
}

std::uint32_t vdbCompression(VdbValues values) {
    return (values == VdbValues::zip ? openvdb::io::COMPRESS_ZIP : openvdb::io::COMPRESS_NONE) |
           openvdb::io::COMPRESS_ACTIVE_MASK;
}

Status writeVdbFile(const fs::path& path, const std::vector<std::shared_ptr<openvdb::GridBase>>& grids,
                    VdbValues values) {
    const Error full{ErrorCode::resourceExhausted, path.string(),
                     "cannot be written whole: is the folder there and writable, and the disk not full?"};
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
    if (!file.good()) return full;
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
