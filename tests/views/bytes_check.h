// SPDX-License-Identifier: GPL-3.0-or-later
//
// BytesCheck: the greatest difference between the cpu device's exact pictures of a view by every kind of
// vectors that the processor has and by one, two and three threads. One owner, one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tests/views/view_check.h"
#include "tests/views/view_data.h"
#include "tests/views/view_drawer.h"

namespace mote::test {

class BytesCheck final : public ViewCheck {
  public:
    BytesCheck();

  private:
    Verdict examine(const proto::View& view) override;

    /// Of one number of threads each; none for a kind of vectors alone.
    std::vector<std::unique_ptr<ViewDrawer>> drawers_;
    ViewData data_;
};

}  // namespace mote::test
