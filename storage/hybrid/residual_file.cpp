// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/residual_file.h"

#include <fmt/format.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <istream>
#include <memory>

#include "storage/files/packed_file.h"
#include "storage/hash.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/residual_encoder.h"
#include "storage/manifest.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

using Leaf = openvdb::FloatTree::LeafNodeType;
static_assert(Leaf::DIM == residualBrickSide);

Status damaged(const fs::path& path, std::string message) {
    return Error{ErrorCode::corrupt, path.string(), std::move(message)};
}

/// Of a file that may be packed.
Result<std::unique_ptr<std::streambuf>> openBytes(const fs::path& path) {
    if (path.extension() == packedSuffix) {
        MOTE_ASSIGN_OR_RETURN(auto packed, PackedSource::open(path));
        return std::unique_ptr<std::streambuf>(std::move(packed));
    }
    auto plain = std::make_unique<std::filebuf>();
    if (plain->open(path, std::ios::in | std::ios::binary))
        return std::unique_ptr<std::streambuf>(std::move(plain));
    return Error{ErrorCode::notFound, path.string(), "cannot be opened"};
}

Result<openvdb::FloatGrid::Ptr> readGrid(const fs::path& path) {
    try {
        openvdb::initialize();
        MOTE_ASSIGN_OR_RETURN(const auto bytes, openBytes(path));
        std::istream in(bytes.get());
        const auto grids = openvdb::io::Stream(in, false).getGrids();
        const auto grid =
            openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::findGridByName(*grids, residualGridName));
        if (grid) return grid;
    } catch (const std::exception& error) {
        return Error{ErrorCode::corrupt, path.string(),
                     fmt::format("is not read by OpenVDB: {}", error.what())};
    }
    return Error{ErrorCode::corrupt, path.string(), "holds no FloatGrid \"residual\""};
}

/// Counts, places and values against the manifest.
Status checkGrid(const openvdb::FloatGrid& grid, const GridSize& size, const proto::HybridStepEntry& entry,
                 const fs::path& path) {
    if (grid.tree().activeTileCount() > 0) return damaged(path, "holds tiles, where all are single samples");
    if (grid.activeVoxelCount() != entry.residual_samples() ||
        grid.tree().leafCount() != entry.residual_bricks()) {
        return damaged(path, "has not as many samples as the manifest says");
    }
    if (grid.empty()) return success();
    const auto box = grid.evalActiveVoxelBoundingBox();
    for (int a = 0; a < 3; ++a) {
        if (box.min()[a] >= 0 &&
            static_cast<std::uint32_t>(box.max()[a]) < size[static_cast<std::size_t>(a)]) {
            continue;
        }
        return damaged(path, "holds a sample outside of the error grid");
    }
    return success();
}

using Values = std::array<float, residualBrickSamples>;

/// The leaf's samples as exact multiples of the step; false where one is none.
bool takeValues(const Leaf& leaf, double step, Values& values) {
    bool good = true;
    for (std::uint32_t i = 0; i < residualBrickSamples; ++i) {
        const auto at = offsetInBrick(i);
        const double multiple = leaf.isValueOn(at) ? std::round(leaf.getValue(at) / step) : 0.0;
        good = good && std::abs(multiple) <= maxResidualMultiple;
        values[i] = static_cast<float>(multiple * step);
    }
    return good;
}

}  // namespace

Status readResidual(const fs::path& directory, const proto::Manifest& manifest, std::uint32_t step,
                    const std::function<void(const ResidualBrick&)>& visit,
                    const std::function<bool()>& cancelled) {
    const auto* entry = findHybridStep(manifest, step);
    if (!entry || entry->residual_file().empty()) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("has no residual of a step {}", step)};
    }
    const auto path = directory / entry->residual_file();
    MOTE_ASSIGN_OR_RETURN(const auto hash, hashFile(path, cancelled));
    const auto& file = *findFile(manifest, entry->residual_file());
    if (hash.size != file.size() || hash.xxh3_128 != file.xxh3_128()) {
        return damaged(
            path, "differs from its hash in the manifest; the dataset is damaged: copy or make it again");
    }
    MOTE_ASSIGN_OR_RETURN(const auto grid, readGrid(path));
    MOTE_RETURN_IF_ERROR(checkGrid(*grid, gridSize(manifest.hybrid().error_size()), *entry, path));
    Values values;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
        if (cancelled && cancelled()) return Error{ErrorCode::cancelled, path.string(), "cancelled"};
        if (!takeValues(*leaf, entry->residual_step(), values)) {
            return damaged(path, "holds a value that is not finite, or too great");
        }
        const auto origin = leaf->origin();
        const auto index = [&](int a) { return static_cast<std::uint32_t>(origin[a]) / residualBrickSide; };
        visit({{index(0), index(1), index(2)}, values});
    }
    return success();
}

std::string residualName(std::uint32_t step) {
    return fmt::format("residual-{:06}.vdb", step);
}

}  // namespace mote::storage
