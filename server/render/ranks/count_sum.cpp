// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/count_sum.h"

#include <cstring>
#include <limits>

#include "protocol/scene/mote_check.h"

namespace mote::render {
namespace {

using Counts = std::span<std::uint32_t>;

/// The counts that a rank adds up.
Counts partOf(Counts counts, std::size_t rank, std::size_t ranks) {
    const std::size_t begin = counts.size() * rank / ranks;
    return counts.subspan(begin, counts.size() * (rank + 1) / ranks - begin);
}

Bytes bytesOf(Counts counts) {
    const auto bytes = std::as_bytes(counts);
    return {bytes.begin(), bytes.end()};
}

void add(const Bytes& bytes, Counts sums) {
    MOTE_CHECK(bytes.size() == sums.size_bytes());
    const std::byte* next = bytes.data();
    for (auto& sum : sums) {
        std::uint32_t more = 0;
        std::memcpy(&more, next, sizeof(more));
        next += sizeof(more);
        sum += more;
        if (sum < more) sum = std::numeric_limits<std::uint32_t>::max();
    }
}

}  // namespace

void addUpCounts(Ranks& ranks, Counts counts) {
    const auto size = static_cast<std::size_t>(ranks.size()), mine = static_cast<std::size_t>(ranks.rank());
    std::vector<Bytes> outgoing(size);
    for (std::size_t rank = 0; rank < size; ++rank)
        if (rank != mine) outgoing[rank] = bytesOf(partOf(counts, rank, size));
    const auto parts = ranks.exchange(outgoing);
    const Counts own = partOf(counts, mine, size);
    for (std::size_t rank = 0; rank < size; ++rank)
        if (rank != mine) add(parts[rank], own);
    outgoing.assign(size, {});
    if (mine != 0) outgoing[0] = bytesOf(own);
    const auto sums = ranks.exchange(outgoing);
    if (mine != 0) return;
    for (std::size_t rank = 1; rank < size; ++rank) {
        MOTE_CHECK(sums[rank].size() == partOf(counts, rank, size).size_bytes());
        if (!sums[rank].empty())
            std::memcpy(partOf(counts, rank, size).data(), sums[rank].data(), sums[rank].size());
    }
}

}  // namespace mote::render
