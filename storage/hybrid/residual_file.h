// SPDX-License-Identifier: GPL-3.0-or-later
//
// residual-%06d.vdb.zst of a dataset of kind "hybrid" (docs/FORMAT.md): what must be added to the
// low-resolution volume, on the samples of the error grid, in an OpenVDB FloatGrid of integer multiples of a
// step. OpenVDB stays behind this header. Any thread; residual_writer.h writes it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/path_beneath.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// The names of the grid in the file, and of its metadata that says the step.
inline constexpr const char* residualGridName = "residual";
inline constexpr const char* residualStepName = "mote_step";

struct ResidualBrick {
    GridSize index{};  ///< of the brick along x, y, z
    /// What is to be added, in the source's unit, x fastest; exact multiples of the step.
    std::span<const float, residualBrickSamples> values;
};

/// Reads a step's residual; `visit` gets every brick that holds any, in a fixed order. The whole file is held
/// to the manifest's hash before it is read, and its counts to the manifest. Errors: notFound, corrupt,
/// invalidArgument (there is no such step or residual), cancelled.
Status readResidual(const PathBeneath& directory, const proto::Manifest& manifest, std::uint32_t step,
                    const std::function<void(const ResidualBrick&)>& visit,
                    const std::function<bool()>& cancelled = {});

/// "residual-000012.vdb", before it is packed
std::string residualName(std::uint32_t step);

}  // namespace mote::storage
