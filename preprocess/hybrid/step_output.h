// SPDX-License-Identifier: GPL-3.0-or-later
//
// The files of a step of a hybrid volume from what all ranks have put aside. Functions without state; called
// on every rank, from one thread.
#pragma once

#include <filesystem>
#include <vector>

#include "preprocess/hybrid/error_selection.h"
#include "preprocess/hybrid/low_volume.h"
#include "preprocess/hybrid/point_row.h"
#include "preprocess/hybrid/step_maker.h"
#include "storage/hybrid/residual_encoder.h"

namespace mote::prep {

/// What a rank has put aside, in its scratch file.
struct CollectedErrors {
    std::vector<PointPiece> points;
    std::vector<storage::ResidualPart> residuals;
};

/// What all ranks know alike.
struct StepContent {
    const LowVolume& low;
    const ErrorSelection& selection;
    const storage::ResidualCoding& coding;  ///< where there are residuals
};

/// Where a rank's scratch file lies.
std::filesystem::path scratchPath(const StepTask& task, int rank);

/// Rank 0 reads everyone's scratch files and writes the step's files; sets their names and counts in its
/// `entry`. Errors, on all ranks: resourceExhausted (disk full), internal, cancelled.
Status writeStep(const StepTask& task, const StepContent& content, const CollectedErrors& mine,
                 proto::HybridStepEntry& entry);

}  // namespace mote::prep
