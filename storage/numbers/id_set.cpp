// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/id_set.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <bit>

#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t wordBits = PointMask::wordBits;
/// So many points are read through in the time that one id takes to be looked up.
constexpr std::uint64_t pointsALookUp = 64;
/// Whether a bit for each id from the least to the greatest takes no more memory than so many ids.
bool close(std::uint64_t least, std::uint64_t greatest, std::uint64_t ids) {
    return (greatest - least) / wordBits < ids;
}

StorageError changedIds() {
    return StorageError(Error{ErrorCode::corrupt, "/columns/id", "was changed while it was read"});
}

/// The ids of a step by their rank.
class Ranks {
  public:
    explicit Ranks(const ParticleColumns& columns) : columns_(columns) {}

    std::uint32_t point(std::uint64_t rank) const { return columns_.pointOfRank(rank); }
    std::uint64_t id(std::uint64_t rank) const { return columns_.ids(point(rank), 1)[0]; }

    /// The first rank from `begin` on whose id is not below this one. Ids lie evenly, mostly one after the
    /// other: where this one would then be, and the rank beside it, are looked at first.
    std::uint64_t lowerBound(std::uint64_t wanted, std::uint64_t begin) const {
        const auto end = columns_.pointCount();
        if (begin == end || id(begin) >= wanted) return begin;
        if (id(end - 1) < wanted) return end;
        Rank low{begin, id(begin)}, high{end - 1, id(end - 1)};  // below, and not below
        const auto look = [&](std::uint64_t rank) {
            if (rank <= low.rank || rank >= high.rank) return;
            const auto found = id(rank);
            (found < wanted ? low : high) = {rank, found};
        };
        for (int guess = 0; high.rank - low.rank > 1; ++guess) {
            const auto at =
                guess < mostGuesses ? expected(wanted, low, high) : low.rank + (high.rank - low.rank) / 2;
            look(at);
            look(low.rank == at ? at + 1 : at - 1);
        }
        return high.rank;
    }

  private:
    static constexpr int mostGuesses = 6;

    struct Rank {
        std::uint64_t rank, id;
    };
    /// A rank between the two, by interpolation.
    static std::uint64_t expected(std::uint64_t wanted, const Rank& low, const Rank& high) {
        const double share = static_cast<double>(wanted - low.id) / static_cast<double>(high.id - low.id);
        const auto step = static_cast<std::uint64_t>(share * static_cast<double>(high.rank - low.rank));
        return std::clamp(low.rank + step, low.rank + 1, high.rank - 1);
    }

    const ParticleColumns& columns_;
};

}  // namespace

IdSet::IdSet(std::vector<std::uint64_t> ids) : size_(ids.size()), ids_(std::move(ids)) {
    if (ids_.empty() || !close(ids_.front(), ids_.back(), size_)) return;
    first_ = ids_.front();
    bits_.assign((ids_.back() - first_) / wordBits + 1, 0);
    for (const auto id : ids_)
        bits_[(id - first_) / wordBits] |= std::uint64_t{1} << ((id - first_) % wordBits);
    ids_ = {};
}

std::optional<IdSet> IdSet::of(const PointMask& mask, const ParticleColumns& columns,
                               const std::function<bool()>& cancelled) {
    const auto& words = mask.words();
    // Where the ids of each block begin, and what the least and the greatest are.
    const std::uint64_t blocks = blockCount(mask.size());
    std::vector<std::uint64_t> begin(blocks + 1, 0), least(blocks, ~std::uint64_t{0}), greatest(blocks, 0);
    const auto visit = [&](std::uint64_t block, auto&& take) {
        const auto points = pointsOfBlock(block, mask.size());
        const auto chosen = std::span(words).subspan(points.begin / wordBits, wordCount(points.count));
        if (!anyChosen(chosen)) return;
        const auto ids = columns.ids(points.begin, points.count);
        forEachChosen(chosen, [&](std::size_t place) { take(ids[place]); });
    };
    bool whole = forBlocks(blocks, cancelled, [&](std::uint64_t block) {
        visit(block, [&](std::uint64_t id) {
            ++begin[block + 1];
            least[block] = std::min(least[block], id);
            greatest[block] = std::max(greatest[block], id);
        });
    });
    if (!whole) return std::nullopt;
    for (std::uint64_t i = 0; i < blocks; ++i) begin[i + 1] += begin[i];
    IdSet set;
    if (begin[blocks] == 0) return set;
    const auto low = *std::min_element(least.begin(), least.end());
    const auto high = *std::max_element(greatest.begin(), greatest.end());
    if (close(low, high, begin[blocks])) {
        set.first_ = low;
        set.bits_.assign((high - low) / wordBits + 1, 0);
        whole = forBlocks(blocks, cancelled, [&](std::uint64_t block) {
            visit(block, [&](std::uint64_t id) {
                // Read anew, where somebody may have written meanwhile.
                if (id < low || id > high) throw changedIds();
                std::atomic_ref word(set.bits_[(id - low) / wordBits]);
                word.fetch_or(std::uint64_t{1} << ((id - low) % wordBits), std::memory_order_relaxed);
            });
        });
        if (!whole) return std::nullopt;
        for (const auto word : set.bits_) set.size_ += static_cast<std::uint64_t>(std::popcount(word));
        return set;
    }
    set.ids_.resize(begin[blocks]);
    whole = forBlocks(blocks, cancelled, [&](std::uint64_t block) {
        auto at = begin[block];
        visit(block, [&](std::uint64_t id) { set.ids_[at++] = id; });
    });
    if (!whole) return std::nullopt;
    tbb::parallel_sort(set.ids_);
    set.ids_.erase(std::unique(set.ids_.begin(), set.ids_.end()), set.ids_.end());
    set.size_ = set.ids_.size();
    return set;
}

bool IdSet::contains(std::uint64_t id) const {
    if (bits_.empty()) return std::binary_search(ids_.begin(), ids_.end(), id);
    if (id < first_ || (id - first_) / wordBits >= bits_.size()) return false;
    return ((bits_[(id - first_) / wordBits] >> ((id - first_) % wordBits)) & 1U) != 0;
}

std::vector<std::uint64_t> IdSet::list() const {
    if (bits_.empty()) return ids_;
    std::vector<std::uint64_t> ids;
    ids.reserve(size_);
    forEachChosen(bits_, [&](std::size_t place) { ids.push_back(first_ + place); });
    return ids;
}

std::optional<PointMask> pointsOf(const IdSet& ids, const ParticleColumns& columns,
                                  const std::function<bool()>& cancelled) {
    const auto points = columns.pointCount();
    PointMask mask(points);
    if (points == 0 || ids.size() == 0) return mask;
    if (ids.size() < points / pointsALookUp) {
        const auto list = ids.list();
        const Ranks ranks(columns);
        // One thread: what it marks lies anywhere, and there is little of it.
        std::uint64_t rank = 0, tried = 0;
        for (const auto id : list) {
            if (++tried % askedEach == 0 && cancelled && cancelled()) return std::nullopt;
            for (rank = ranks.lowerBound(id, rank); rank < points && ranks.id(rank) == id; ++rank)
                mask.choose(ranks.point(rank));
            if (rank >= points) break;
        }
        return mask;
    }
    const bool whole = forBlocks(blockCount(points), cancelled, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, points);
        const auto own = columns.ids(part.begin, part.count);
        auto* const words = mask.words().data() + part.begin / wordBits;
        for (std::size_t i = 0; i < own.size(); ++i)
            words[i / wordBits] |= std::uint64_t{ids.contains(own[i])} << (i % wordBits);
    });
    if (!whole) return std::nullopt;
    return mask;
}

std::optional<std::vector<std::uint32_t>> firstPoints(std::span<const std::uint64_t> ids,
                                                      const ParticleColumns& columns,
                                                      const std::function<bool()>& cancelled) {
    std::vector<std::uint32_t> points(ids.size(), noPoint);
    const Ranks ranks(columns);
    const bool whole = forBlocks(blockCount(ids.size()), cancelled, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, ids.size());
        std::uint64_t rank = 0;
        for (auto i = part.begin; i < part.begin + part.count; ++i) {
            rank = ranks.lowerBound(ids[i], rank);
            if (rank >= columns.pointCount()) break;
            if (ranks.id(rank) == ids[i]) points[i] = ranks.point(rank);
        }
    });
    if (!whole) return std::nullopt;
    return points;
}

}  // namespace mote::storage
