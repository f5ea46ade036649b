// SPDX-License-Identifier: GPL-3.0-or-later
//
// TileLists: items sorted by the tiles that they touch, in their order within each. Owned by who fills it;
// its memory is reused.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"

namespace mote::render {

template <class Item>
class TileLists {
  public:
    std::span<Item> of(std::size_t tile) {
        return {items_.data() + begin_[tile], begin_[tile + 1] - begin_[tile]};
    }
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
    /// the calling arena, in turns (plan/in_turns.h). Stops early where `stop` is requested.
    template <class Prepare, class ForEach>
    void fill(std::size_t tiles, std::size_t chunks, const std::stop_token& stop, Prepare prepare,
              ForEach forEach) {
        // Where there are many tiles, chunks that follow each other share their counts.
        const std::size_t runs = std::min(chunks, std::max<std::size_t>(mostPlaces / tiles, 1));
        const auto forRun = [&](std::size_t run, auto body) {
            const std::size_t end = (run + 1) * chunks / runs;
            for (std::size_t chunk = run * chunks / runs; chunk < end && !stop.stop_requested(); ++chunk)
                body(chunk);
        };
        // Where the next item of each run and tile goes; first, how many there are.
        auto places = listInTurns<std::uint32_t>(runs * tiles);
        forInTurns(std::size_t{0}, runs, [&](std::size_t run) {
            std::uint32_t* const counts = places.data() + run * tiles;
            forRun(run, [&](std::size_t chunk) {
                prepare(chunk);
                forEach(chunk, [counts](std::size_t tile, const Item&) { ++counts[tile]; });
            });
        });
        begin_.assign(tiles + 1, 0);
        forRangesInTurns(tiles, rangeTiles, [&](const auto& range) {
            for (std::size_t run = 0; run < runs; ++run) {
                for (std::size_t tile = range.begin(); tile < range.end(); ++tile) {
                    auto& place = places[run * tiles + tile];
                    const std::uint32_t count = place;
                    place = static_cast<std::uint32_t>(begin_[tile + 1]);
                    begin_[tile + 1] += count;
                }
            }
        });
        for (std::size_t tile = 0; tile < tiles; ++tile) begin_[tile + 1] += begin_[tile];
        resizeInTurns(items_, begin_.back());
        forInTurns(std::size_t{0}, runs, [&](std::size_t run) {
            std::uint32_t* const next = places.data() + run * tiles;
            forRun(run, [&](std::size_t chunk) {
                forEach(chunk, [&](std::size_t tile, const Item& item) {
                    items_[begin_[tile] + next[tile]++] = item;
                });
            });
        });
    }

  private:
    static constexpr std::size_t mostPlaces = std::size_t{1} << 22;  // 16 MiB
    static constexpr std::size_t rangeTiles = 1024;

    std::vector<Item> items_;
    std::vector<std::size_t> begin_;  // where each tile's begin, and the end
};

}  // namespace mote::render
