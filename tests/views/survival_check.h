// SPDX-License-Identifier: GPL-3.0-or-later
//
// SurvivalCheck: a device draws a view exactly and at several qualities of a view in motion. What it owes is
// a picture of the right size, or a sentence. One owner, one thread.
#pragma once

#include "tests/views/view_check.h"
#include "tests/views/view_data.h"
#include "tests/views/view_drawer.h"

namespace mote::test {

class SurvivalCheck final : public ViewCheck {
  public:
    explicit SurvivalCheck(std::unique_ptr<ViewDrawer> drawer) : drawer_(std::move(drawer)) {}

  private:
    Verdict examine(const proto::View& view) override;

    std::unique_ptr<ViewDrawer> drawer_;
    ViewData data_;
};

}  // namespace mote::test
