// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlayedSeries: the series whose steps were asked for last, how each is played, and what the pictures of its
// latest step needed (`Need`). A value; its owner locks it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <memory>

#include "protocol/mote.pb.h"
#include "protocol/scene/most_recent.h"
#include "server/data/play_order.h"

namespace mote::server {

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
    /// Null where none of its steps were asked for of late.
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
