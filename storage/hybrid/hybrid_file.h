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
#include "storage/arrays/array_file_writer.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/hybrid_points.h"

namespace mote::storage {

/// Samples of the low-resolution volume, x fastest: value = valueMin + code * valueStep of the step's entry.
using LowCodes = std::variant<std::span<const std::uint8_t>, std::span<const std::uint16_t>>;

/// What a step's file has room for.
struct HybridStepShape {
    GridSize lowSize{};
    std::uint32_t valueBits = 8;   ///< of a sample of the low-resolution volume, 8 or 16
    std::uint32_t pointBytes = 0;  ///< of a point, 5, 6 or 9; 0: there are none
    GridSize errorSize{};
    std::uint64_t points = 0;
};

/// A step's file while it is written: every array whole before finish(). Move-only; one owner, one thread.
class HybridStepWriter {
  public:
    /// Makes `directory`/NAME.h5. Errors: as ArrayFileWriter.
    static Result<HybridStepWriter> create(const std::filesystem::path& directory, const std::string& name,
                                           const HybridStepShape& shape);

    /// `normals` (NormalTable) point towards lower values, in the world. Errors: as ArrayFileWriter::write.
    Status writeLow(const LowCodes& codes, std::span<const std::uint8_t> normals) const;
    /// Some points, in the form that the shape says, from the `first` on. Errors: as above.
    Status writePoints(std::uint64_t first, const HybridPoints& some) const;
    /// Writes where each brick's points begin, and the last ones end, for 5 bytes a point. Errors: as above.
    Status writeBricks(std::span<const std::uint64_t> begin) const;
    /// Makes the digest. Errors: as ArrayFileWriter.
    Status finish() const { return file_.finish(); }

  private:
    HybridStepWriter(ArrayFileWriter file, std::uint32_t pointBytes)
        : file_(std::move(file)), pointBytes_(pointBytes) {}
    template <class T>
    Status put(std::size_t array, std::uint64_t first, std::span<const T> values) const {
        return file_.write(array, first * sizeof(T), std::as_bytes(values));
    }

    ArrayFileWriter file_;
    std::uint32_t pointBytes_;
};

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
    /// The points; without any where the dataset has none.
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
