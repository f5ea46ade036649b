// SPDX-License-Identifier: GPL-3.0-or-later
//
// Silent: the progress of a job that nobody looks at. Any thread.
#pragma once

#include <string_view>

#include "preprocess/job.h"

namespace mote::test {

class Silent final : public prep::Progress {
  public:
    void report(double, std::string_view) override {}
    void note(std::string_view) override {}
    bool cancelled() const override { return false; }
};

}  // namespace mote::test
