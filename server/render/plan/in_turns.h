// SPDX-License-Identifier: GPL-3.0-or-later
//
// Loops on many threads that a thread may run which works in turns (work_in_turns.h): where its turn ends
// they end with it, but for what is begun, and go on from there in the next one. A step must not depend on
// the others. Elsewhere they are tbb::parallel_for.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "server/render/plan/work_in_turns.h"

namespace mote::render {

/// body(i) for each i from `begin` to before `end`.
template <class Index, class Body>
void forInTurns(Index begin, Index end, const Body& body) {
    Undisturbed loop;
    if (!loop.inTurns() || !(begin < end)) return tbb::parallel_for(begin, end, body);
    std::vector<std::uint8_t> done(static_cast<std::size_t>(end - begin));
    std::atomic<std::size_t> left = done.size();
    while (left > 0) {
        const std::size_t before = left;
        tbb::parallel_for(begin, end, [&](Index i) {
            auto& one = done[static_cast<std::size_t>(i - begin)];
            // A little in any case, so that it comes to its end.
            if (one != 0 || (left < before && loop.isOver())) return;
            body(i);
            one = 1;
            --left;
        });
        loop.giveWay();
    }
}

/// body(range) for ranges of at least `grain`, the last one apart, that cover those from 0 to before `end`.
template <class Body>
void forRangesInTurns(std::size_t end, std::size_t grain, const Body& body) {
    using Range = tbb::blocked_range<std::size_t>;
    {
        const Undisturbed loop;
        if (!loop.inTurns()) return tbb::parallel_for(Range(0, end, grain), body);
    }
    forInTurns(std::size_t{0}, (end + grain - 1) / grain,
               [&](std::size_t i) { body(Range(i * grain, std::min(end, (i + 1) * grain), grain)); });
}

/// body(part, i) for each i from 0 to before `end`, in any order, those of one part one after the other.
/// Stops early where `stop` is requested.
template <class Body>
void forPartsInTurns(std::size_t parts, std::size_t end, const std::stop_token& stop, const Body& body) {
    Undisturbed loop;
    std::atomic<std::size_t> next{0};
    while (next < end && !stop.stop_requested()) {
        tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
            for (auto i = next++; i < end && !stop.stop_requested(); i = next++) {
                body(part, i);
                if (loop.inTurns() && loop.isOver()) return;
            }
        });
        if (loop.inTurns()) loop.giveWay();
    }
}

/// Pixels of which each takes long are drawn by parts of rows, which begin at multiples of so many.
inline constexpr std::uint32_t partOfARow = 512;

/// How many parts a picture has, row by row, and which one begins there.
inline std::size_t partsOfRows(std::uint32_t width, std::uint32_t height) {
    return std::size_t{(width + partOfARow - 1) / partOfARow} * height;
}
inline std::size_t partOfRows(std::uint32_t width, std::uint32_t row, std::uint32_t column) {
    return partsOfRows(width, row) + column / partOfARow;
}

/// body(row, from, to) for each part: from column to before column.
template <class Body>
void forPixelsInTurns(std::uint32_t width, std::uint32_t height, const Body& body) {
    const std::size_t inARow = std::max<std::size_t>(partsOfRows(width, 1), 1);
    forInTurns(std::size_t{0}, partsOfRows(width, height), [&](std::size_t i) {
        const auto row = static_cast<std::uint32_t>(i / inARow),
                   from = static_cast<std::uint32_t>(i % inARow) * partOfARow;
        body(row, from, std::min(width, from + partOfARow));
    });
}

}  // namespace mote::render
