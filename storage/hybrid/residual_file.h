// SPDX-License-Identifier: GPL-3.0-or-later
//
// residual-%06d.vdb of a dataset of kind "hybrid" (docs/FORMAT.md): what must be added to the low-resolution
// volume, on the samples of the error grid, in an OpenVDB FloatGrid of integer multiples of a step. OpenVDB
// stays behind this header. A ResidualGrid has one thread; reading has any.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <memory>
#include <span>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

class ResidualGrid {
  public:
    /// The greatest multiple of the step, by magnitude, that a file keeps.
    static constexpr std::int32_t maxMultiple = 1 << 22;
    /// Of memory for each brick: the tree's leaf of floats, and its codes on the way there.
    static constexpr std::uint64_t bytesPerBrick = 2400;

    /// `errorToWorld`: from indices of the error grid's samples. `step` is positive, in the source's unit.
    ResidualGrid(const GridSize& size, double step, const glm::dmat4& errorToWorld);
    ResidualGrid(ResidualGrid&&) noexcept;
    ResidualGrid& operator=(ResidualGrid&&) = delete;
    ~ResidualGrid();

    /// The brick with this index along each axis, each once; multiples of the step, x fastest, zero where
    /// nothing is added. In the end the order in which they came does not matter.
    void add(const GridSize& brick, std::span<const std::int32_t, residualBrickSamples> multiples);

    std::uint64_t samples() const { return samples_; }  ///< that are not zero
    std::uint64_t bricks() const { return bricks_; }

    /// Makes `path`: as halves where these are exact enough to be read back, else as floats. The same bricks
    /// give the same bytes. Errors: as writeVdbFile.
    Status write(const std::filesystem::path& path) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
    GridSize size_;
    double step_;
    std::uint64_t samples_ = 0, bricks_ = 0;
    std::int32_t greatest_ = 0;  ///< multiple, by magnitude
};

struct ResidualBrick {
    GridSize index{};  ///< of the brick along x, y, z
    /// What is to be added, in the source's unit, x fastest; exact multiples of the step.
    std::span<const float, residualBrickSamples> values;
};

/// Reads a step's residual; `visit` gets every brick that holds any, in a fixed order. The whole file is held
/// to the manifest's hash before OpenVDB sees it, and its counts to the manifest. Errors: notFound, corrupt,
/// invalidArgument (there is no such step or residual), cancelled.
Status readResidual(const std::filesystem::path& directory, const proto::Manifest& manifest,
                    std::uint32_t step, const std::function<void(const ResidualBrick&)>& visit,
                    const std::function<bool()>& cancelled = {});

/// "residual-000012.vdb"
std::string residualName(std::uint32_t step);

}  // namespace mote::storage
