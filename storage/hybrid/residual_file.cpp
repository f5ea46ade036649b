// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/residual_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <memory>
#include <streambuf>
#include <utility>
#include <vector>

#include "storage/files/dataset_file.h"
#include "storage/files/packed_file.h"
#include "storage/hash.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/residual_encoder.h"
#include "storage/hybrid/residual_reader.h"
#include "storage/manifest.h"

namespace mote::storage {
namespace {

Status damaged(const PathBeneath& path, std::string message) {
    return Error{ErrorCode::corrupt, path.string(), std::move(message)};
}

/// An open file's bytes as they are.
class PlainSource final : public std::streambuf {
  public:
    explicit PlainSource(FileDescriptor file) : file_(std::move(file)) {}

  private:
    int_type underflow() override {
        ssize_t got = 0;
        do {
            got = ::read(file_.get(), bytes_.data(), bytes_.size());
        } while (got < 0 && errno == EINTR);
        if (got <= 0) return traits_type::eof();
        setg(bytes_.data(), bytes_.data(), bytes_.data() + got);
        return traits_type::to_int_type(*gptr());
    }

    FileDescriptor file_;
    std::vector<char> bytes_ = std::vector<char>(1 << 16);
};

std::unique_ptr<std::streambuf> bytesOf(FileDescriptor file, bool packed) {
    if (packed) return std::make_unique<PackedSource>(std::move(file));
    return std::make_unique<PlainSource>(std::move(file));
}

using Values = std::array<float, residualBrickSamples>;

/// A leaf's samples as exact multiples of the step; false if one is none.
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

Status readResidual(const PathBeneath& directory, const proto::Manifest& manifest, std::uint32_t step,
                    const std::function<void(const ResidualBrick&)>& visit,
                    const std::function<bool()>& cancelled) {
    const auto* entry = findHybridStep(manifest, step);
    if (!entry || entry->residual_file().empty()) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("has no residual of a step {}", step)};
    }
    const auto path = directory / entry->residual_file();
    // One opening for both, so that no other file's bytes are read than were hashed.
    MOTE_ASSIGN_OR_RETURN(auto file, openRegular(path));
    MOTE_ASSIGN_OR_RETURN(const auto hash, hashFile(file.get(), path.path(), cancelled));
    const auto& described = *findFile(manifest, entry->residual_file());
    if (hash.size != described.size() || hash.xxh3_128 != described.xxh3_128()) {
        return damaged(
            path, "differs from its hash in the manifest; the dataset is damaged: copy or make it again");
    }
    const auto bytes = bytesOf(std::move(file), path.path().extension() == packedSuffix);
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
