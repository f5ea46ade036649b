// SPDX-License-Identifier: GPL-3.0-or-later
//
// Long arrays between ranks, a piece at a time, so that none holds another's whole. A function without state.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/parallel/communicator.h"

namespace mote::prep {

/// All ranks call it. take(rank, first, values) gets everyone's values, the ranks in order and each one's in
/// ascending `first`, but not all of a rank at once. Errors: as Communicator::share.
template <class T, class Take>
Status sharePieces(Communicator& ranks, std::span<const T> mine, const Take& take) {
    constexpr std::uint64_t most = (std::uint64_t{1} << 22) / sizeof(T);
    const std::uint64_t length = mine.size();
    MOTE_ASSIGN_OR_RETURN(const auto lengths, shareValues<std::uint64_t>(ranks, std::span(&length, 1)));
    std::uint64_t longest = 0;
    for (const auto& of : lengths) longest = std::max(longest, of.front());
    for (std::uint64_t first = 0; first < longest; first += most) {
        const auto begin = std::min(first, length);
        MOTE_ASSIGN_OR_RETURN(const auto all,
                              shareValues<T>(ranks, mine.subspan(begin, std::min(most, length - begin))));
        for (std::size_t rank = 0; rank < all.size(); ++rank) {
            take(rank, first, std::span<const T>(all[rank]));
        }
    }
    return success();
}

}  // namespace mote::prep
