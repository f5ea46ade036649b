// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is made of a foreign file where nobody says: the kind of dataset, how it is prepared and drawn, and
// why. Functions without state; called from one thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/look/found.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// One thing that was chosen, for people and scripts.
struct Reason {
    std::string what;   ///< "axes"
    std::string value;  ///< "x,px,y"
    std::string why;    ///< a clause
};

/// A dataset that is to be made, and what else it needs.
struct AutoChoice {
    proto::JobRequest request;    ///< without an output
    std::vector<Reason> reasons;  ///< one a decision
    proto::JobRequest dots;       ///< of the plane of dots that a photograph is drawn with; else empty
};

/// Three quantities of a run for a plot's axes, and why these.
struct ChosenAxes {
    std::vector<std::string> axes;
    std::string why;  ///< a clause
};

/// Those that vary, if there are three.
ChosenAxes chooseAxes(const Found& run);

/// Chooses one of what `look` found at `input`: particles before volumes before meshes before pictures, of
/// several the largest. A volume's form is tried out on slices from its middle, in a folder beside `output`
/// that is removed again. Errors: unsupported (nothing is found that can be prepared: why), those of volume
/// jobs, cancelled.
Result<AutoChoice> chooseAutomatically(const Look& look, const std::filesystem::path& output,
                                       const JobResources& resources, Progress& progress);

/// The same of a volume alone: how many samples its low-resolution volume has, and whether what is left is
/// kept as residuals, or the volume is exact. docs/AUTO.md has the balance and what it was held against.
Status balanceVolume(const Found& volume, const std::filesystem::path& input,
                     const std::filesystem::path& output, const JobResources& resources, Progress& progress,
                     AutoChoice& choice);

}  // namespace mote::prep
