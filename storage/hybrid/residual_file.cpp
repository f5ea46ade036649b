// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/residual_file.h"

#include <fmt/format.h>

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
#include "storage/hybrid/residual_reader.h"
#include "storage/manifest.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

Status damaged(const fs::path& path, std::string message) {
    return Error{ErrorCode::corrupt, path.string(), std::move(message)};
}

/// Opens a file that may be packed.
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

using Values = std::array<float, residualBrickSamples>;

/// A leaf's samples as exact multiples of the step; false where one is none.
bool takeValues(std::span<const float, residualBrickSamples> leaf, double step, Values& values) {
    bool good = true;
    for (std::uint32_t i = 0; i < residualBrickSamples; ++i) {
        const double multiple = std::round(leaf[offsetInBrick(i)] / step);
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
    MOTE_ASSIGN_OR_RETURN(const auto bytes, openBytes(path));
    ResidualReader reader(
        *bytes,
        {gridSize(manifest.hybrid().error_size()), entry->residual_bricks(), entry->residual_samples()},
        path.string());
    Values values;
    Status visited = success();
    const auto take = [&](const GridSize& brick, std::span<const float, residualBrickSamples> leaf) {
        if (cancelled && cancelled()) {
            visited = Error{ErrorCode::cancelled, path.string(), "cancelled"};
        } else if (!takeValues(leaf, entry->residual_step(), values)) {
            visited = damaged(path, "holds a value that is not finite, or too great");
        }
        if (visited.ok()) visit({brick, values});
        return visited.ok();
    };
    MOTE_RETURN_IF_ERROR(reader.read(take, cancelled));
    return visited;
}

std::string residualName(std::uint32_t step) {
    return fmt::format("residual-{:06}.vdb", step);
}

}  // namespace mote::storage
