// SPDX-License-Identifier: GPL-3.0-or-later
//
// DissolveCheck: each layer of particles and each hybrid volume of a view becomes two, of w and of 1 - w of
// its opacity, as far as a view may have so many: a device's exact picture stays what it was
// (docs/PICTURE.md, "Layers that fade"). One owner, one thread.
#pragma once

#include <memory>
#include <utility>

#include "tests/views/view_check.h"
#include "tests/views/view_data.h"
#include "tests/views/view_drawer.h"

namespace mote::test {

class DissolveCheck final : public ViewCheck {
  public:
    explicit DissolveCheck(std::unique_ptr<ViewDrawer> drawer) : drawer_(std::move(drawer)) {}

  private:
    Verdict examine(const proto::View& view) override;

    std::unique_ptr<ViewDrawer> drawer_;
    ViewData data_;
};

/// The same view with two layers for each that is of matter; how much of it the first has, is drawn by the
/// view's own numbers.
proto::View dissolved(const proto::View& view);

}  // namespace mote::test
