// SPDX-License-Identifier: GPL-3.0-or-later
//
// SilentNotes: a Progress whose notes are not said on the way, for who tells them later (KeptNotes over it).
// One owner.
#pragma once

#include <string_view>

#include "preprocess/job.h"

namespace mote::prep {

class SilentNotes : public Progress {
  public:
    explicit SilentNotes(Progress& progress) : progress_(progress) {}
    void report(double fraction, std::string_view phase) override { progress_.report(fraction, phase); }
    void note(std::string_view) override {}
    bool cancelled() const override { return progress_.cancelled(); }

  private:
    Progress& progress_;
};

}  // namespace mote::prep
