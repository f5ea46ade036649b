// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlayedSeries: the series whose steps were asked for last, how each is played, and what the pictures of its
// latest step needed (`Need`). A value; its owner locks it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "protocol/base/most_recent.h"
#include "protocol/mote.pb.h"

namespace mote::server {

/// PlayOrder: tells from the steps of a dataset that were asked for one after the other which will be asked
/// for next: whoever plays them goes one way by even steps, forwards or backwards, and begins anew at the
/// end. A value; one owner.
class PlayOrder {
  public:
    /// `steps`: how many the dataset has, at least one.
    explicit PlayOrder(std::uint32_t steps) : steps_(steps) {}

    /// False if it is the same step again, which changes nothing.
    bool asked(std::uint32_t step);
    /// The next ones, the nearest first; none if there is no order.
    std::vector<std::uint32_t> next(std::size_t most) const;

  private:
    std::int64_t stride() const;

    std::int64_t steps_;
    std::int64_t last_ = -1;
    std::int64_t latest_ = 0, before_ = 0;  ///< the last strides; 0: there was none
};

/// How many steps are loaded ahead of a series that is played.
inline constexpr std::size_t stepsAhead = 4;

template <class Need>
class PlayedSeries {
  public:
    /// Tells a dataset from a later one of its name.
    using Manifest = std::shared_ptr<const proto::Manifest>;

    struct Series {
        Manifest manifest;
        PlayOrder order;
        Need need = {};
    };

    /// `steps` of the dataset, at least one.
    Series& of(const Manifest& manifest, int steps) {
        return mostRecent(
            all_, kept, [&](const Series& one) { return one.manifest == manifest; },
            [&] {
                return Series{manifest, PlayOrder(static_cast<std::uint32_t>(steps))};
            });
    }
    /// Null if none of its steps were asked for of late.
    const Series* find(const Manifest& manifest) const {
        const auto found = std::find_if(all_.begin(), all_.end(),
                                        [&](const Series& one) { return one.manifest == manifest; });
        return found == all_.end() ? nullptr : &*found;
    }

  private:
    static constexpr std::size_t kept = 16;

    std::list<Series> all_;  // the latest first
};

}  // namespace mote::server
