// SPDX-License-Identifier: GPL-3.0-or-later
//
// DifferenceCheck: how far a device's exact picture is from the reference, pixels in doubt left out. A view
// more than half of whose pixels are in doubt is undecided. One owner, one thread.
#pragma once

#include <filesystem>
#include <optional>

#include "tests/views/doubt.h"
#include "tests/views/view_check.h"
#include "tests/views/view_data.h"
#include "tests/views/view_drawer.h"

namespace mote::test {

class DifferenceCheck final : public ViewCheck {
  public:
    explicit DifferenceCheck(std::unique_ptr<ViewDrawer> drawer) : drawer_(std::move(drawer)) {}

  private:
    Verdict examine(const proto::View& view) override;

    std::unique_ptr<ViewDrawer> drawer_;
    ViewData data_;
};

/// Fills in how far `actual` is from what is expected.
void measure(const Image& actual, const Judgement& judgement, Verdict& verdict);

}  // namespace mote::test
