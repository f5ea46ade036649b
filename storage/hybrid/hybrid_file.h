// SPDX-License-Identifier: GPL-3.0-or-later
//
// step-%06d.h5 and its digest of a dataset of kind "hybrid" (docs/FORMAT.md): the low-resolution volume, its
// normals, and points. Writing has one thread at a time in a process (HDF5); a HybridStep is read-only, and
// its spans may be used from any thread while it lives.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/arrays/array_file.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/hybrid_points.h"

namespace mote::storage {

/// Samples of the low-resolution volume, x fastest: value = valueMin + code * valueStep of the step's entry.
using LowCodes = std::variant<std::span<const std::uint8_t>, std::span<const std::uint16_t>>;

struct HybridStepContent {
    GridSize lowSize{};
    LowCodes low;
    std::span<const std::uint8_t> lowNormal;  ///< NormalTable; towards lower values, in the world
    const HybridPoints* points = nullptr;     ///< null: the dataset has none
};

/// Makes `directory`/NAME.h5 and .digest. Errors: as writeArrayFile.
Status writeHybridStep(const std::filesystem::path& directory, const std::string& name,
                       const HybridStepContent& content);

class HybridStep {
  public:
    /// Step `step` of a dataset whose manifest was checked: every byte held to its digest, every count and
    /// place checked. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset of another
    /// kind, a step that there is not).
    static Result<HybridStep> open(const std::filesystem::path& directory, const proto::Manifest& manifest,
                                   std::uint32_t step);

    const GridSize& lowSize() const { return lowSize_; }
    const LowCodes& low() const { return low_; }
    std::span<const std::uint8_t> lowNormal() const { return lowNormal_; }
    /// Without any where the dataset has none.
    const HybridPoints& points() const { return points_; }

    /// What became of the file while it was read (mapped_file.h).
    Status check() const { return file_.check(); }

  private:
    explicit HybridStep(ArrayFile file) : file_(std::move(file)) {}
    Status readLow(std::uint32_t bits);
    Status readPoints(std::uint32_t bytes, std::uint64_t count);
    Status checkPoints() const;

    ArrayFile file_;
    GridSize lowSize_{};
    LowCodes low_;
    std::span<const std::uint8_t> lowNormal_;
    HybridPoints points_;
};

}  // namespace mote::storage
