// SPDX-License-Identifier: GPL-3.0-or-later
//
// One step of a hybrid volume: its files from its source. Called from one thread on every rank; works on the
// caller's oneTBB threads. The same source gives the same bytes for any number of ranks and threads and any
// memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct StepTask {
    Communicator& ranks;
    const VolumePlan& plan;
    const ValueRange& range;  ///< of all steps
    const VolumeMemory& memory;
    std::filesystem::path directory;  ///< of the dataset while it is made
    std::uint32_t step = 0;
    /// The share of the step's time, measured, by which all errors are found.
    static constexpr double errorsEnd = 0.85;
    /// Takes the done share of this step, 0 to 1, and what is done; an error ends the step.
    std::function<Status(double, std::string_view)> report;
};

/// Makes step-%06d.h5, .digest and residual-%06d.vdb; returns their entry, but for time and invalid samples,
/// which is whole on rank 0 alone. `source` is this rank's own. Errors: those of any rank's source,
/// resourceExhausted (disk), cancelled.
Result<proto::HybridStepEntry> makeHybridStep(VolumeSource& source, const StepTask& task);

}  // namespace mote::prep
