// SPDX-License-Identifier: GPL-3.0-or-later
//
// RunSource: where questions for numbers get a run of particles from. Any number of threads.
#pragma once

#include <memory>
#include <string>

#include "protocol/scene/error.h"
#include "storage/numbers/run_steps.h"

namespace mote::server {

class RunSource {
  public:
    virtual ~RunSource() = default;
    /// `dataset` as in the catalogue. The same run as long as the dataset is the same. Errors: notFound,
    /// invalidArgument (it is no particle plot).
    virtual Result<std::shared_ptr<const storage::RunSteps>> run(const std::string& dataset) = 0;
};

}  // namespace mote::server
