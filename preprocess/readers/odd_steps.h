// SPDX-License-Identifier: GPL-3.0-or-later
//
// OddSteps: steps of a series that cannot be read beside others that can. One of them is no reason to give up
// the rest: it is left out, and said so. A value of the reader that opens the series; one thread.
#pragma once

#include <cstddef>
#include <optional>

#include "preprocess/job.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class OddSteps {
  public:
    /// Keeps an error that is of one file or step alone, and passes on those that are of the whole run
    /// (cancelled, a wrong option, no memory).
    Status add(const Status& opened);

    /// Notes what was left out. The first error where nothing was read.
    Status finish(bool anyRead, Progress& progress) const;

  private:
    std::optional<Error> first_;
    std::size_t count_ = 0;
};

}  // namespace mote::prep
