// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes a built step to its file, all ranks together: each collects the points of parts of the file from
// those that have them, and writes those parts. Called from one thread; uses all threads of its arena.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "preprocess/particles/step_builder.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

struct StepOutput {
    std::filesystem::path directory;  ///< of the dataset while it is made
    std::string name;                 ///< "step-000012"
    storage::StepAttributes attributes;
    Communicator* ranks = nullptr;
    std::function<bool()> cancelled;
    /// Called by rank 0 when the file is complete, while the others still read it.
    std::function<Status()> complete;
};

/// Makes NAME.h5 and NAME.digest; returns where the arrays lie in it. Errors: resourceExhausted (disk full),
/// permissionDenied, cancelled, internal; the same on all ranks. Parts of the files may be left.
Result<storage::StepFile::Places> writeBuiltStep(const BuiltStep& step, const StepOutput& output);

}  // namespace mote::prep
