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
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/arrays/array_file.h"
#include "storage/files/path_beneath.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// A point as its codes say it.
struct HybridPoint {
    GridSize place{};         ///< the sample of the error grid
    std::uint8_t value = 0;   ///< code of the source's value there
    std::uint8_t error = 0;   ///< code of the error, source minus low-resolution volume
    std::uint8_t normal = 0;  ///< NormalTable
};

/// The points of a hybrid volume as they lie on disk, in any of their forms (docs/FORMAT.md): 5
/// bytes each, with a place in a brick of 32^3 samples; or 6 or 9, with a place in the whole error grid of
/// one or two bytes a coordinate. A view of bytes that somebody else owns; any thread.
struct HybridPoints {
    GridSize grid{};  ///< of the error grid
    /// Points of brick b are brickBegin[b] to brickBegin[b + 1]; bricks x fastest, then y, then z. Empty:
    /// flat.
    std::span<const std::uint64_t> brickBegin;
    /// How far a point's place x + 32 y + 1024 z in its brick is from the one before it there, of the first
    /// from 0: 5 bytes a point.
    std::span<const std::uint16_t> advance;
    std::span<const std::uint8_t> place8;    ///< x, y, z of each: 6 bytes a point
    std::span<const std::uint16_t> place16;  ///< x, y, z of each: 9 bytes a point
    std::span<const std::uint8_t> value, error, normal;

    std::uint64_t size() const { return value.size(); }
    /// Bricks that cover the error grid, x fastest.
    GridSize bricks() const { return bricksOf(grid, pointBrickSide); }

    /// Calls visit(HybridPoint) for each point, brick by brick. In the flat forms, too, they lie in that
    /// order.
    template <class Visit>
    void forEach(const Visit& visit) const {
        if (brickBegin.empty()) return forEachFlat(visit);
        const auto counts = bricks();
        for (std::uint64_t brick = 0; brick + 1 < brickBegin.size(); ++brick) {
            const GridSize at{static_cast<std::uint32_t>(brick % counts[0]),
                              static_cast<std::uint32_t>(brick / counts[0] % counts[1]),
                              static_cast<std::uint32_t>(brick / counts[0] / counts[1])};
            forEachIn(at, brickBegin[brick], brickBegin[brick + 1], visit);
        }
    }

    /// Visits points [begin, end) of the brick with the index `at`; only in the hierarchical form.
    template <class Visit>
    void forEachIn(const GridSize& at, std::uint64_t begin, std::uint64_t end, const Visit& visit) const {
        constexpr std::uint32_t side = pointBrickSide;
        std::uint32_t p = 0;
        for (auto i = begin; i < end; ++i) {
            // Where a file made to harm leads out of the brick, it leads back into it.
            p = (p + advance[i]) % (side * side * side);
            visit(HybridPoint{
                {at[0] * side + p % side, at[1] * side + p / side % side, at[2] * side + p / side / side},
                value[i],
                error[i],
                normal[i]});
        }
    }

  private:
    template <class Visit>
    void forEachFlat(const Visit& visit) const {
        const auto coordinate = [&](std::uint64_t i) -> std::uint32_t {
            return place8.empty() ? place16[i] : place8[i];
        };
        for (std::uint64_t i = 0; i < size(); ++i) {
            visit(HybridPoint{{coordinate(3 * i), coordinate(3 * i + 1), coordinate(3 * i + 2)},
                              value[i],
                              error[i],
                              normal[i]});
        }
    }
};

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
    Result<FileHash> finish() const { return file_.finish(); }

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

/// The most bytes of a step's file that holds what the manifest, which was checked, says.
std::uint64_t mostHybridStepBytes(const proto::HybridManifest& hybrid, const proto::HybridStepEntry& entry);

class HybridStep {
  public:
    /// Step `step` of a dataset whose manifest was checked: every byte held to its digest, every count and
    /// place checked. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset of another
    /// kind, a step that there is not).
    static Result<HybridStep> open(const PathBeneath& directory, const proto::Manifest& manifest,
                                   std::uint32_t step);

    const GridSize& lowSize() const { return lowSize_; }
    const LowCodes& low() const { return low_; }
    std::span<const std::uint8_t> lowNormal() const { return lowNormal_; }
    /// The points; without any if the dataset has none. Where the bricks' points begin is our own copy,
    /// but codes and places are read where they lie: whoever goes by a place holds it to the grid, as the
    /// file may be written to meanwhile.
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
    std::vector<std::uint64_t> brickBegin_;
    HybridPoints points_;
};

}  // namespace mote::storage
