// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidualEncoder: bricks of a residual as they will lie in its OpenVDB file, a part of them at a time. Parts
// of one residual may be made by several threads and processes; residual_writer.h joins them. OpenVDB stays
// behind this header. One owner, one thread.
//
// A residual's file (docs/FORMAT.md) from its encoded parts. Holds one node of the tree at a time, and of
// all others where they are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "storage/files/dataset_file.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// Of OpenVDB's files, as all are written and read here.
inline constexpr std::uint32_t residualFileVersion = 224;
/// The greatest multiple of the step, by magnitude, that a file keeps.
inline constexpr std::int32_t maxResidualMultiple = 1 << 22;
/// A node of OpenVDB's tree, in bricks a side.
inline constexpr std::uint32_t residualNodeBricks = 16;

/// OpenVDB's offset of a brick's sample i, which has x fastest where OpenVDB has z.
constexpr std::uint32_t offsetInBrick(std::uint32_t i) {
    return (i & 7U) << 6U | (i & 56U) | i >> 6U;
}

/// How all bricks of a residual are kept.
struct ResidualCoding {
    GridSize size{};               ///< of the error grid
    double step = 0.0;             ///< positive, in the source's unit
    glm::dmat4 errorToWorld{1.0};  ///< from indices of the error grid's samples
    bool halves = false;           ///< values are stored as halves, else as floats
};

/// Whether multiples up to `greatest`, by magnitude, survive as halves.
bool fitHalves(double greatest, double step);

/// Some bricks of one node, in a scratch file. Trivially copyable, so that processes can exchange it.
struct ResidualPart {
    GridSize node{};                      ///< index of the node along x, y, z
    std::uint32_t scratch = 0;            ///< which file; the caller's to set
    std::uint64_t offset = 0, bytes = 0;  ///< where in it
    std::uint64_t bricks = 0, samples = 0;
    GridSize begin{}, end{};  ///< the box of its samples
};

/// A brick's place among those of its node, in the order of the file, and what follows it in the part.
struct EncodedBrick {
    std::uint32_t place = 0;
    std::uint32_t bytes = 0;  ///< its mask, then its values
};

class ResidualEncoder {
  public:
    /// Encodes the node with this index. `coding` must outlive this.
    ResidualEncoder(const ResidualCoding& coding, const GridSize& node);
    ~ResidualEncoder();
    ResidualEncoder(const ResidualEncoder&) = delete;
    ResidualEncoder& operator=(const ResidualEncoder&) = delete;

    /// A brick of this node, by its index in the grid, each once; multiples of the step, x fastest, zero
    /// where nothing is added.
    void add(const GridSize& brick, std::span<const std::int32_t, residualBrickSamples> multiples);

    /// All of them, or nothing if there is no sample. Errors: as ScratchFile::append.
    Result<std::optional<ResidualPart>> store(ScratchFile& scratch) const;

  private:
    struct Stream;
    const ResidualCoding& coding_;
    ResidualPart part_;
    std::vector<EncodedBrick> bricks_;
    std::vector<char> bytes_;
    std::unique_ptr<Stream> stream_;
};

/// Makes `path` from parts in any order; part.scratch is an index into `scratches`. The same bricks give the
/// same bytes, whatever their parts. Errors: as writeVdbFile and ScratchFile::read.
Status writeResidual(const std::filesystem::path& path, const ResidualCoding& coding,
                     const std::vector<ResidualPart>& parts,
                     std::span<const std::unique_ptr<ScratchFile>> scratches);

}  // namespace mote::storage
