// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlayOrder: tells from the steps of a dataset that were asked for one after the other which will be asked
// for next: whoever plays them goes one way by even steps, forwards or backwards, and begins anew at the end.
// A value; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mote::server {

class PlayOrder {
  public:
    /// `steps`: how many the dataset has, at least one.
    explicit PlayOrder(std::uint32_t steps) : steps_(steps) {}

    /// False where it is the same step again, which changes nothing.
    bool asked(std::uint32_t step);
    /// The next ones, the nearest first; none where there is no order.
    std::vector<std::uint32_t> next(std::size_t most) const;

  private:
    std::int64_t stride() const;

    std::int64_t steps_;
    std::int64_t last_ = -1;
    std::int64_t latest_ = 0, before_ = 0;  ///< the last strides; 0: there was none
};

}  // namespace mote::server
