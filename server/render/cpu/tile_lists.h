// SPDX-License-Identifier: GPL-3.0-or-later
//
// TileLists: items sorted by the tiles that they touch, in their order within each. Owned by who fills it;
// its memory is reused.
#pragma once

#include <oneapi/tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

namespace mote::render {

template <class Item>
class TileLists {
  public:
    std::span<const Item> of(std::size_t tile) const {
        return {items_.data() + begin_[tile], begin_[tile + 1] - begin_[tile]};
    }

    std::uint64_t bytes() const {
        return items_.capacity() * sizeof(Item) + begin_.capacity() * sizeof(std::size_t);
    }

    void clear(std::size_t tiles) {
        items_.clear();
        begin_.assign(tiles + 1, 0);
    }

    /// forEach(chunk, visit) calls visit(tile, item) for each item of a chunk, in the same order every time:
    /// it is called twice a chunk, to count and to place, after one call of prepare(chunk); on any threads of
    /// the calling arena. Stops early where `stop` is requested.
    template <class Prepare, class ForEach>
    void fill(std::size_t tiles, std::size_t chunks, const std::stop_token& stop, Prepare prepare,
              ForEach forEach) {
        // Where the next item of each chunk and tile goes; first, how many there are.
        std::vector<std::uint32_t> places(chunks * tiles, 0);
        tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
            if (stop.stop_requested()) return;
            std::uint32_t* const counts = places.data() + chunk * tiles;
            prepare(chunk);
            forEach(chunk, [counts](std::size_t tile, const Item&) { ++counts[tile]; });
        });
        begin_.assign(tiles + 1, 0);
        for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
            for (std::size_t tile = 0; tile < tiles; ++tile) {
                const std::uint32_t count = places[chunk * tiles + tile];
                places[chunk * tiles + tile] = static_cast<std::uint32_t>(begin_[tile + 1]);
                begin_[tile + 1] += count;
            }
        }
        for (std::size_t tile = 0; tile < tiles; ++tile) begin_[tile + 1] += begin_[tile];
        items_.resize(begin_.back());
        tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
            if (stop.stop_requested()) return;
            std::uint32_t* const next = places.data() + chunk * tiles;
            forEach(chunk,
                    [&](std::size_t tile, const Item& item) { items_[begin_[tile] + next[tile]++] = item; });
        });
    }

  private:
    std::vector<Item> items_;
    std::vector<std::size_t> begin_;  // where each tile's begin, and the end
};

}  // namespace mote::render
