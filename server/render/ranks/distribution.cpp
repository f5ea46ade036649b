// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/distribution.h"

#include <algorithm>
#include <bit>

namespace mote::render {
namespace {

// A word of bits at least; at most some megabytes of points, of which the blocks at both ends are shared.
constexpr std::size_t shortestRun = 64;
constexpr std::size_t longestRun = std::size_t{1} << 17;
/// So many runs a rank: the last ones, which not every rank gets, are a small share of all.
constexpr std::size_t runsPerRank = 32;

}  // namespace

LeafDistribution::LeafDistribution(std::size_t leaves, int ranks) : ranks_(ranks) {
    const std::size_t fair = leaves / (runsPerRank * static_cast<std::size_t>(ranks));
    shift_ = static_cast<unsigned>(std::bit_width(std::clamp(fair, shortestRun, longestRun))) - 1;
}

std::vector<std::uint64_t> LeafDistribution::own(const std::vector<std::uint64_t>& inView, std::size_t count,
                                                 int rank) const {
    constexpr std::size_t bits = 64;
    std::vector<std::uint64_t> result((count + bits - 1) / bits);
    for (std::size_t word = 0; word < result.size(); ++word) {
        // A run is a whole number of words.
        if (owner(word * bits) == rank) result[word] = inView.empty() ? ~std::uint64_t{0} : inView[word];
    }
    return result;
}

}  // namespace mote::render
