// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/octree.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "protocol/base/mote_check.h"

namespace mote::prep {
namespace {

/// A leaf on its way to its place in the file, by which it is put in order.
struct LeafKey {
    std::uint32_t density;  ///< the bits of the float, which are in its order from 0 on
    std::uint32_t place;    ///< in the list of what else is known of it
    std::uint64_t cell;     ///< cellCode()

    friend bool operator<(const LeafKey& a, const LeafKey& b) {
        return a.density != b.density ? a.density < b.density : a.cell < b.cell;
    }
};

struct LeafData {
    std::uint32_t node;  ///< among all
    std::uint32_t points;
    std::uint32_t source;  ///< its first point
};

/// Leaves that are in the slice of one rank.
struct LeafList {
    std::vector<LeafKey> keys;
    std::vector<LeafData> data;

    void resize(std::size_t size) {
        tbb::parallel_invoke([&] { keys.resize(size); }, [&] { data.resize(size); });
    }

    void reserve(std::size_t size) {
        keys.reserve(size);
        data.reserve(size);
    }

    /// Adds leaves, whose places go on from those that are here.
    void append(std::span<const LeafKey> someKeys, std::span<const LeafData> someData) {
        const auto before = static_cast<std::uint32_t>(keys.size());
        resize(keys.size() + someKeys.size());
        std::ranges::transform(someKeys, keys.begin() + before, [&](LeafKey key) {
            key.place += before;
            return key;
        });
        std::ranges::copy(someData, data.begin() + before);
    }
};

/// A leaf that stands for others of about its density, which take so long to write, in points.
struct LeafSample {
    LeafKey key;
    std::uint64_t cost;
};

/// What a rank tells of its slice.
struct SliceSum {
    std::uint64_t leaves, points;
    Range densities;  ///< above zero
};

/// What stands before each place of a list: sums of numbers, found side by side.
template <class Number>
class SumsBefore {
  public:
    /// `number(i)` of the places [0, size), the same whenever it is asked.
    SumsBefore(std::size_t size, Number number)
        : size_(size), number_(std::move(number)), before_((size + together - 1) / together + 1) {
        forEachBlock([&](std::size_t block, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) before_[block + 1] += number_(i);
        });
        std::inclusive_scan(before_.begin(), before_.end(), before_.begin());
    }

    std::uint64_t total() const { return before_.back(); }

    /// Calls `use(i, sum of the numbers before i)` for each place.
    template <class Use>
    void forEach(const Use& use) const {
        forEachBlock([&](std::size_t block, std::size_t begin, std::size_t end) {
            std::uint64_t sum = before_[block];
            for (std::size_t i = begin; i < end; ++i) {
                use(i, sum);
                sum += number_(i);
            }
        });
    }

  private:
    static constexpr std::size_t together = std::size_t{1} << 13;

    template <class Use>
    void forEachBlock(const Use& use) const {
        tbb::parallel_for(std::size_t{0}, before_.size() - 1, [&](std::size_t block) {
            use(block, block * together, std::min(size_, (block + 1) * together));
        });
    }

    std::size_t size_;
    Number number_;
    std::vector<std::uint64_t> before_;  ///< by block, and one more
};

/// A stable sort by density, the least significant bits first. Digits that are the same everywhere cost a
/// look.
class DensitySort {
  public:
    explicit DensitySort(std::vector<LeafKey>& leaves)
        : leaves_(leaves), other_(leaves.size()), parts_((leaves.size() + together - 1) / together) {}

    void run() {
        for (unsigned shift = 0; shift < bits; shift += digitBits) {
            count(shift);
            if (findPlaces()) move(shift);
        }
    }

  private:
    static constexpr unsigned bits = 32, digitBits = 11;
    static constexpr std::size_t digits = std::size_t{1} << digitBits;
    static constexpr std::size_t together = std::size_t{1} << 17;
    using Places = std::array<std::uint32_t, digits>;

    static std::size_t digitOf(const LeafKey& leaf, unsigned shift) {
        return leaf.density >> shift & (digits - 1);
    }

    template <class Use>
    void forEach(const Use& use) {
        tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t part) {
            const std::size_t begin = part * together;
            use(std::span(leaves_).subspan(begin, std::min(together, leaves_.size() - begin)), parts_[part]);
        });
    }

    void count(unsigned shift) {
        forEach([&](std::span<const LeafKey> leaves, Places& counts) {
            counts.fill(0);
            for (const auto& leaf : leaves) ++counts[digitOf(leaf, shift)];
        });
    }

    /// Makes places of counts; false: there is only one digit, so all are there.
    bool findPlaces() {
        std::uint32_t at = 0;
        for (std::size_t digit = 0; digit < digits; ++digit) {
            const auto before = at;
            for (auto& part : parts_) at += std::exchange(part[digit], at);
            if (before == 0 && at == leaves_.size()) return false;
        }
        return true;
    }

    void move(unsigned shift) {
        forEach([&](std::span<const LeafKey> leaves, Places& places) {
            for (const auto& leaf : leaves) other_[places[digitOf(leaf, shift)]++] = leaf;
        });
        leaves_.swap(other_);
    }

    std::vector<LeafKey>& leaves_;
    std::vector<LeafKey> other_;
    std::vector<Places> parts_;  ///< by part of the leaves, by digit: how many, then where the next one goes
};

/// A sort by cell of what is in order but for a few places: the runs between them are merged.
void mergeRuns(std::vector<LeafKey>::iterator begin, std::vector<LeafKey>::iterator end) {
    const auto less = [](const LeafKey& a, const LeafKey& b) { return a.cell < b.cell; };
    const auto first = std::is_sorted_until(begin, end, less);
    if (first == end) return;
    std::vector runs{begin, first};
    while (runs.back() != end) runs.push_back(std::is_sorted_until(runs.back(), end, less));
    while (runs.size() > 2) {
        std::size_t kept = 1;
        for (std::size_t i = 2; i < runs.size(); i += 2) {
            std::inplace_merge(runs[i - 2], runs[i - 1], runs[i], less);
            runs[kept++] = runs[i];
        }
        if (runs.size() % 2 == 0) runs[kept++] = runs.back();
        runs.resize(kept);
    }
}

/// Sorts leaves that are in order by density by cell, too, those of one density together.
void sortByCell(std::vector<LeafKey>& leaves) {
    constexpr std::size_t together = std::size_t{1} << 13;
    const auto less = [](const LeafKey& a, const LeafKey& b) { return a.density < b.density; };
    // The first density that begins in a block or behind it: no density is in two blocks.
    std::vector<std::vector<LeafKey>::iterator> first;
    for (std::size_t at = 0; at < leaves.size(); at += together) {
        const auto begin = leaves.begin() + static_cast<std::ptrdiff_t>(at);
        first.push_back(at == 0 ? begin : std::upper_bound(begin - 1, leaves.end(), *(begin - 1), less));
    }
    first.push_back(leaves.end());
    tbb::parallel_for(std::size_t{1}, first.size(), [&](std::size_t block) {
        for (auto begin = first[block - 1]; begin < first[block];) {
            const auto end = std::find_if(
                begin, first[block], [&](const LeafKey& leaf) { return leaf.density != begin->density; });
            mergeRuns(begin, end);
            begin = end;
        }
    });
}

/// Calls `use(i)` for i of [begin, end), side by side.
template <class Use>
void forEachOf(std::size_t begin, std::size_t end, const Use& use) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, 1 << 13), [&](const auto& part) {
        for (auto i = part.begin(); i < part.end(); ++i) use(i);
    });
}

/// Side by side: fresh memory takes longer to come than to fill.
template <class... Lists>
void resizeAll(std::size_t size, Lists&... lists) {
    tbb::parallel_invoke([&] { lists.resize(size); }...);
}

/// Puts the leaves of all ranks in their order, each rank a slice: leaves go to the rank whose slice they are
/// in, which sorts them and tells where they are.
class LeafOrder {
  public:
    /// `tree` has its nodes; `source`, by node, its first point. All references outlive this.
    LeafOrder(Octree& tree, const std::vector<std::uint32_t>& source, Communicator& ranks)
        : tree_(tree), source_(source), ranks_(ranks), slices_(static_cast<std::size_t>(ranks.size())) {
        constexpr std::size_t together = std::size_t{1} << 13;
        for (const auto& run : tree_.runs) {
            for (std::size_t at = 0; at < run.count; at += together) {
                const std::size_t begin = run.first + at;
                blocks_.push_back({begin, begin + std::min(together, run.count - at), run.place - run.first});
            }
        }
    }

    Status run() {
        MOTE_RETURN_IF_ERROR(findSplitters());
        MOTE_ASSIGN_OR_RETURN(auto leaves, exchange());
        DensitySort(leaves.keys).run();
        sortByCell(leaves.keys);
        return fill(std::move(leaves));
    }

  private:
    /// Nodes that one thread looks at.
    struct Block {
        std::size_t begin, end;
        std::uint64_t toPlace;  ///< what is added to a node for its number among all
    };

    /// Where a rank's leaves are in the list of this slice.
    struct Received {
        std::size_t begin, count;
    };

    std::size_t own() const { return static_cast<std::size_t>(ranks_.rank()); }
    bool isLeaf(std::size_t node) const { return tree_.childCount[node] == 0; }

    LeafKey keyOf(std::size_t node) const {
        return {std::bit_cast<std::uint32_t>(tree_.density[node]), 0,
                cellCode(tree_.morton[node], tree_.level[node])};
    }

    std::size_t sliceOf(std::size_t node) const {
        if (splitters_.empty()) return 0;
        const auto after = std::upper_bound(splitters_.begin(), splitters_.end(), keyOf(node));
        return static_cast<std::size_t>(after - splitters_.begin());
    }

    /// The first key of each slice but the first, so that each takes about as long to write, by a sample.
    Status findSplitters() {
        if (slices_ == 1) return success();
        MOTE_ASSIGN_OR_RETURN(const auto shared, shareValues<LeafSample>(ranks_, sample()));
        std::vector<LeafSample> all;
        std::uint64_t total = 0, before = 0;
        for (const auto& samples : shared) all.insert(all.end(), samples.begin(), samples.end());
        for (const auto& one : all) total += one.cost;
        std::ranges::sort(all, [](const LeafSample& a, const LeafSample& b) { return a.key < b.key; });
        for (const auto& one : all) {
            while (splitters_.size() + 1 < slices_ && before >= total / slices_ * (splitters_.size() + 1))
                splitters_.push_back(one.key);
            before += one.cost;
        }
        return success();
    }

    std::vector<LeafSample> sample() const {
        constexpr std::uint64_t wanted = std::uint64_t{1} << 14;  // nodes: a slice is right to a hundredth
        std::uint64_t nodes = 0;
        for (const auto& run : tree_.runs) nodes += run.count;
        const std::uint64_t step = nodes / wanted + 1;
        std::vector<LeafSample> samples;
        for (const auto& run : tree_.runs) {
            for (std::size_t node = run.first; node < run.first + run.count; node += step) {
                if (isLeaf(node))
                    samples.push_back({keyOf(node), (tree_.count[node] + pointsPerLeaf) * step});
            }
        }
        return samples;
    }

    /// Calls `use(node, slice)` for the leaves of a block.
    template <class Use>
    void forEachLeaf(const Block& block, const Use& use) const {
        for (std::size_t node = block.begin; node < block.end; ++node) {
            if (isLeaf(node)) use(node, sliceOf(node));
        }
    }

    /// Calls `use(node, slice, place in the slice's list)` for all leaves of this rank, blocks side by side.
    template <class Use>
    void forEachDealt(const Use& use) const {
        tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t block) {
            const auto first = first_.begin() + static_cast<std::ptrdiff_t>(block * slices_);
            std::vector<std::uint32_t> next(first, first + static_cast<std::ptrdiff_t>(slices_));
            forEachLeaf(blocks_[block],
                        [&](std::size_t node, std::size_t slice) { use(block, node, slice, next[slice]++); });
        });
    }

    /// Puts this rank's leaves of its own slice into `mine`; returns those of the others as messages.
    std::vector<Bytes> deal(LeafList& mine) {
        first_.assign((blocks_.size() + 1) * slices_, 0);
        tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t block) {
            forEachLeaf(blocks_[block],
                        [&](std::size_t, std::size_t slice) { ++first_[(block + 1) * slices_ + slice]; });
        });
        for (std::size_t i = slices_; i < first_.size(); ++i) first_[i] += first_[i - slices_];
        std::vector<Bytes> outgoing(slices_);
        std::vector<LeafKey*> keys;
        std::vector<LeafData*> data;
        for (std::size_t slice = 0; slice < slices_; ++slice) {
            const std::size_t count = first_[blocks_.size() * slices_ + slice];
            if (slice == own()) {
                mine.resize(count);
                keys.push_back(mine.keys.data());
                data.push_back(mine.data.data());
                continue;
            }
            auto& bytes = outgoing[slice];
            bytes.reserve(listBytes<LeafKey>(count) + listBytes<LeafData>(count));
            const std::size_t keysAt = addRoom<LeafKey>(bytes, count),
                              dataAt = addRoom<LeafData>(bytes, count);
            keys.push_back(reinterpret_cast<LeafKey*>(bytes.data() + keysAt));
            data.push_back(reinterpret_cast<LeafData*>(bytes.data() + dataAt));
        }
        forEachDealt([&](std::size_t block, std::size_t node, std::size_t slice, std::uint32_t at) {
            keys[slice][at] = keyOf(node);
            keys[slice][at].place = at;
            data[slice][at] = {static_cast<std::uint32_t>(node + blocks_[block].toPlace),
                               static_cast<std::uint32_t>(tree_.count[node]), source_[node]};
        });
        return outgoing;
    }

    /// All ranks' leaves of this rank's slice: its own, then one other's after another's.
    Result<LeafList> exchange() {
        LeafList all;
        // Memory that is not touched costs nothing; so what comes has room, as a rule.
        if (slices_ > 1) all.reserve(tree_.nodeTotal / slices_);
        MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(deal(all)));
        received_.assign(slices_, {0, all.keys.size()});
        for (std::size_t from = 0; from < slices_; ++from) {
            if (from == own()) continue;
            std::span<const std::byte> rest(incoming[from]);
            const auto keys = takeList<LeafKey>(rest);
            received_[from] = {all.keys.size(), keys.size()};
            all.append(keys, takeList<LeafData>(rest));
        }
        return all;
    }

    /// Makes the lists of the tree's leaves of those that are in order.
    Status fill(LeafList leaves) {
        const std::size_t size = leaves.keys.size();
        resizeAll(size, tree_.leafNode, tree_.leafPointBegin, tree_.leafPointCount, tree_.leafDensity,
                  tree_.leafSource, tree_.leafCell);
        std::vector<std::uint32_t> leafOf(size);  // by place in the list
        forEachOf(0, size, [&](std::size_t leaf) {
            const auto& key = leaves.keys[leaf];
            const auto& data = leaves.data[key.place];
            leafOf[key.place] = static_cast<std::uint32_t>(leaf);
            tree_.leafNode[leaf] = data.node;
            tree_.leafPointCount[leaf] = data.points;
            tree_.leafDensity[leaf] = std::bit_cast<float>(key.density);
            tree_.leafSource[leaf] = data.source;
            tree_.leafCell[leaf] = key.cell;
        });
        leaves = {};
        const SumsBefore points(size,
                                [&](std::size_t leaf) { return std::uint64_t{tree_.leafPointCount[leaf]}; });
        MOTE_RETURN_IF_ERROR(shareSums(points.total()));
        const std::uint64_t first = tree_.slicePoint[own()];
        points.forEach(
            [&](std::size_t leaf, std::uint64_t before) { tree_.leafPointBegin[leaf] = first + before; });
        return tellPlaces(leafOf);
    }

    Status shareSums(std::uint64_t points) {
        SliceSum mine{tree_.leafNode.size(), points, {}};
        const auto& density = tree_.leafDensity;
        const auto first = std::upper_bound(density.begin(), density.end(), 0.0F);
        if (first != density.end()) mine.densities = {*first, density.back()};
        MOTE_ASSIGN_OR_RETURN(const auto sums, shareValues<SliceSum>(ranks_, std::span(&mine, 1)));
        tree_.slicePoint = {0};
        sliceLeaf_ = {0};
        for (const auto& of : sums) {
            tree_.slicePoint.push_back(tree_.slicePoint.back() + of.front().points);
            sliceLeaf_.push_back(sliceLeaf_.back() + of.front().leaves);
            tree_.leafDensities = tree_.leafDensities.united(of.front().densities);
        }
        tree_.leafBefore = sliceLeaf_[own()];
        tree_.leafTotal = sliceLeaf_.back();
        return success();
    }

    /// Tells each rank where its leaves are, whose nodes say so.
    Status tellPlaces(std::span<const std::uint32_t> leafOf) {
        std::vector<Bytes> outgoing(slices_);
        std::vector<std::span<const std::uint32_t>> of(slices_);
        for (std::size_t rank = 0; rank < slices_; ++rank) {
            of[rank] = leafOf.subspan(received_[rank].begin, received_[rank].count);
            if (rank != own()) outgoing[rank] = bytesOf(std::as_bytes(of[rank]));
        }
        MOTE_ASSIGN_OR_RETURN(const auto incoming, ranks_.exchange(std::move(outgoing)));
        for (std::size_t slice = 0; slice < slices_; ++slice) {
            if (slice != own()) of[slice] = spanOf<std::uint32_t>(incoming[slice]);
        }
        forEachDealt([&](std::size_t, std::size_t node, std::size_t slice, std::uint32_t at) {
            tree_.firstChild[node] = static_cast<std::uint32_t>(sliceLeaf_[slice] + of[slice][at]);
        });
        return success();
    }

    Octree& tree_;
    const std::vector<std::uint32_t>& source_;
    Communicator& ranks_;
    std::size_t slices_;
    std::vector<Block> blocks_;
    std::vector<LeafKey> splitters_;
    std::vector<std::uint32_t> first_;      ///< by block and slice, where its leaves begin in the list
    std::vector<Received> received_;        ///< by rank
    std::vector<std::uint64_t> sliceLeaf_;  ///< each slice's first leaf, and one more
};

class Assembly {
  public:
    Assembly(OctreePart part, Communicator& ranks)
        : ranks_(ranks),
          units_(std::move(part.units)),
          found_(std::move(part.found)),
          firstUnit_(part.firstUnit),
          top_(part.top.size()),
          levels_(std::move(part.top)) {
        for (auto& level : part.below) levels_.push_back(std::move(level));
        for (std::size_t i = 0; i < firstUnit_ + found_.size(); ++i)
            (i < firstUnit_ ? particles_.begin : particles_.end) += units_[i].count;
        particles_.end += particles_.begin;
    }

    Result<Octree> run() {
        MOTE_RETURN_IF_ERROR(shareDivisions());
        MOTE_RETURN_IF_ERROR(placeLevels());
        linkNodes();
        MOTE_RETURN_IF_ERROR(weigh());
        levels_ = {};
        MOTE_RETURN_IF_ERROR(tellDensities());
        MOTE_RETURN_IF_ERROR(LeafOrder(tree_, source_, ranks_).run());
        return std::move(tree_);
    }

  private:
    /// Of a level, counted from its first node.
    struct Nodes {
        std::size_t begin = 0, end = 0;
    };
    /// What ranks tell each other of a unit.
    struct UnitSum {
        double weight;
        float minDensity;
    };

    /// How the units of all ranks are divided, and what those of this rank weigh that are not.
    Status shareDivisions() {
        std::vector<std::uint8_t> mine;
        for (std::size_t i = 0; i < found_.size(); ++i) {
            const auto& unit = units_[firstUnit_ + i];
            mine.push_back(found_[i].children);
            levels_[unit.level].weight[unit.index] = found_[i].weight;
        }
        MOTE_ASSIGN_OR_RETURN(const auto shared, shareValues<std::uint8_t>(ranks_, mine));
        auto unit = units_.begin();
        for (const auto& children : shared) {
            for (const auto mask : children) {
                if (unit->divided) levels_[unit->level].children[unit->index] = mask;
                ++unit;
            }
        }
        MOTE_CHECK(unit == units_.end());
        return success();
    }

    /// Finds where the nodes of each level stand, here and among all.
    Status placeLevels() {
        std::vector<std::uint64_t> mine;
        for (std::size_t depth = top_; depth < levels_.size(); ++depth) mine.push_back(levels_[depth].size());
        MOTE_ASSIGN_OR_RETURN(const auto below, shareValues<std::uint64_t>(ranks_, mine));
        std::uint64_t total = 0;
        for (std::size_t depth = 0; depth < levels_.size(); ++depth) {
            levelPlace_.push_back(total);
            std::uint64_t before = 0, all = 0;
            for (std::size_t rank = 0; depth >= top_ && rank < below.size(); ++rank) {
                if (rank == static_cast<std::size_t>(ranks_.rank())) before = all;
                all += below[rank][depth - top_];
            }
            toPlace_.push_back(total + before - first_.back());
            total += depth < top_ ? levels_[depth].size() : all;
            first_.push_back(first_.back() + levels_[depth].size());
        }
        levelPlace_.push_back(total);
        toPlace_.push_back(0);
        tree_.nodeTotal = total;
        if (total > std::numeric_limits<std::uint32_t>::max()) {
            return Error{ErrorCode::resourceExhausted, "",
                         "the octree has more than 2^32 nodes; raise the leaf capacity"};
        }
        resizeAll(first_.back(), tree_.level, tree_.morton, tree_.firstChild, tree_.childCount, tree_.count,
                  tree_.density, tree_.minDensity, source_);
        return success();
    }

    /// Children stand side by side, in the order of their parents: each level is in Morton order.
    void linkNodes() {
        for (std::size_t depth = 0; depth < levels_.size(); ++depth) {
            const auto& level = levels_[depth];
            const auto mine = ownOf(depth);
            addRun(depth, mine);
            if (depth + 1 == top_) grid_ = mine;
            // Of a level that is whole, all children are counted, of whichever rank.
            const std::uint64_t next =
                depth < top_ ? levelPlace_[depth + 1] : toPlace_[depth + 1] + first_[depth + 1];
            const auto childrenOf = [&](std::size_t i) {
                return static_cast<std::uint8_t>(std::popcount(level.children[i]));
            };
            SumsBefore(level.size(), childrenOf).forEach([&](std::size_t i, std::uint64_t before) {
                const std::size_t node = first_[depth] + i;
                tree_.firstChild[node] = static_cast<std::uint32_t>(next + before);
                tree_.level[node] = static_cast<std::uint8_t>(depth);
                tree_.childCount[node] = childrenOf(i);
                tree_.count[node] = level.count[i];
                if (holdsChildren(depth, i)) placeChildren(node, level.children[i], levels_[depth + 1]);
            });
        }
    }

    /// The nodes of a level whose first particle is one of this rank's.
    Nodes ownOf(std::size_t depth) const {
        if (depth >= top_) return {0, levels_[depth].size()};
        const std::size_t end = firstUnit_ + found_.size();
        return {nodesBefore(depth, firstUnit_, particles_.begin), nodesBefore(depth, end, particles_.end)};
    }

    /// Those that begin before a unit, which begins with this particle.
    std::size_t nodesBefore(std::size_t depth, std::size_t unit, std::size_t particles) const {
        if (unit == 0) return 0;
        if (unit == units_.size()) return levels_[depth].size();
        const auto level = std::span(source_).subspan(first_[depth], levels_[depth].size());
        return static_cast<std::size_t>(std::ranges::lower_bound(level, particles) - level.begin());
    }

    void addRun(std::size_t depth, const Nodes& nodes) {
        if (nodes.begin == nodes.end) return;
        const std::size_t first = first_[depth] + nodes.begin, count = nodes.end - nodes.begin;
        auto& runs = tree_.runs;
        if (!runs.empty() && runs.back().first + runs.back().count == first &&
            runs.back().place + runs.back().count == first + toPlace_[depth]) {
            runs.back().count += count;
        } else {
            runs.push_back({first, count, first + toPlace_[depth]});
        }
    }

    /// Whether a node has children that this rank holds.
    bool holdsChildren(std::size_t depth, std::size_t i) const {
        return levels_[depth].children[i] != 0 && (depth + 1 != top_ || (grid_.begin <= i && i < grid_.end));
    }

    /// The first child of a node that has some that this rank holds.
    std::size_t childOf(std::size_t node) const {
        return tree_.firstChild[node] - toPlace_[tree_.level[node] + 1U];
    }

    void placeChildren(std::size_t node, unsigned mask, const OctreeLevel& below) {
        std::size_t child = childOf(node);
        std::uint32_t source = source_[node];
        for (unsigned number = 0; number < 8; ++number) {
            if ((mask >> number & 1U) == 0) continue;
            tree_.morton[child] = tree_.morton[node] * 8 + number;
            source_[child] = source;
            source += below.count[child - first_[tree_.level[node] + 1U]];
            ++child;
        }
    }

    /// Finds weights, densities and least densities, from the deepest level up.
    Status weigh() {
        for (std::size_t depth = levels_.size(); depth-- > top_;) weighNodes(depth, ownOf(depth));
        weighNodes(top_ - 1, grid_);
        MOTE_RETURN_IF_ERROR(shareUnits());
        for (std::size_t depth = top_ - 1; depth-- > 0;) weighNodes(depth, {0, levels_[depth].size()});
        tree_.totalWeight = levels_[0].weight[0];
        Status mine = success();
        if (tooLarge_) {
            mine = Error{ErrorCode::resourceExhausted, "", "the weights are too large for their densities"};
        }
        return agree(ranks_, mine);
    }

    void weighNodes(std::size_t depth, const Nodes& nodes) {
        forEachOf(nodes.begin, nodes.end, [&](std::size_t i) {
            if (!weighNode(depth, i)) tooLarge_.store(true, std::memory_order_relaxed);
        });
    }

    bool weighNode(std::size_t depth, std::size_t i) {
        const std::size_t node = first_[depth] + i;
        double& weight = levels_[depth].weight[i];
        float least = std::numeric_limits<float>::infinity();
        for (std::size_t k = 0; k < tree_.childCount[node]; ++k) {
            const std::size_t child = childOf(node) + k;
            weight += levels_[depth + 1].weight[child - first_[depth + 1]];
            least = std::min(least, tree_.minDensity[child]);
        }
        const double density = std::ldexp(weight, static_cast<int>(3 * depth));
        tree_.density[node] = static_cast<float>(density);
        tree_.minDensity[node] = tree_.childCount[node] == 0 ? tree_.density[node] : least;
        return density <= std::numeric_limits<float>::max();
    }

    /// What other ranks' units weigh, by which the levels above them are weighed on all ranks.
    Status shareUnits() {
        if (ranks_.size() == 1) return success();
        std::vector<UnitSum> mine;
        for (std::size_t i = 0; i < found_.size(); ++i) {
            const auto& unit = units_[firstUnit_ + i];
            mine.push_back(
                {levels_[unit.level].weight[unit.index], tree_.minDensity[first_[unit.level] + unit.index]});
        }
        MOTE_ASSIGN_OR_RETURN(const auto shared, shareValues<UnitSum>(ranks_, mine));
        auto unit = units_.begin();
        for (const auto& sums : shared) {
            for (const auto& sum : sums) {
                levels_[unit->level].weight[unit->index] = sum.weight;
                const std::size_t node = first_[unit->level] + unit->index;
                tree_.density[node] =
                    static_cast<float>(std::ldexp(sum.weight, static_cast<int>(3U * unit->level)));
                tree_.minDensity[node] = sum.minDensity;
                ++unit;
            }
        }
        return success();
    }

    /// Finds Octree::toldDensities.
    Status tellDensities() {
        std::vector<float> known(tree_.density.size());  // by node: the density that it is told by
        if (!known.empty()) known[0] = tree_.density[0];
        Range range;
        // Level by level: what a node is told by, its parent has found.
        for (std::size_t depth = 0; depth + 1 < first_.size(); ++depth) {
            range = tbb::parallel_reduce(
                tbb::blocked_range<std::size_t>(first_[depth], first_[depth + 1], std::size_t{1} << 13),
                range,
                [&](const auto& nodes, Range told) {
                    for (auto node = nodes.begin(); node != nodes.end(); ++node)
                        told = tell(depth, node, known, told);
                    return told;
                },
                [](const Range& a, const Range& b) { return a.united(b); });
        }
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<Range>(ranks_, std::span(&range, 1)));
        for (const auto& of : all) tree_.toldDensities = tree_.toldDensities.united(of.front());
        return success();
    }

    Range tell(std::size_t depth, std::size_t node, std::vector<float>& known, const Range& range) const {
        if (tree_.childCount[node] > 0) {
            const std::size_t i = node - first_[depth];
            if (depth + 1 == top_ && (i < grid_.begin || i >= grid_.end)) return range;
            for (std::size_t child = childOf(node); child < childOf(node) + tree_.childCount[node]; ++child)
                known[child] = tree_.count[child] >= counted ? tree_.density[child] : known[node];
            return range;
        }
        if (!(tree_.density[node] > 0.0F)) return range;
        const double density = known[node] > 0.0F ? known[node] : tree_.density[node];
        return range.united({density, density});
    }

    Communicator& ranks_;
    std::vector<PlanUnit> units_;
    std::vector<UnitTree> found_;
    std::size_t firstUnit_;
    std::size_t top_;      ///< how many levels are whole on all ranks
    OctreeLevels levels_;  ///< these, then this rank's below
    Octree tree_;
    Nodes grid_;                             ///< this rank's of the last level that is whole
    Nodes particles_;                        ///< this rank's, in Morton order
    std::vector<std::size_t> first_{0};      ///< by level: its first node
    std::vector<std::uint64_t> levelPlace_;  ///< by level: the number of its first node among all
    std::vector<std::uint64_t> toPlace_;     ///< by level: what is added to a node for its number among all
    std::vector<std::uint32_t> source_;      ///< by node: its first particle in Morton order
    std::atomic<bool> tooLarge_{false};
};

}  // namespace

storage::OctreeNodes Octree::nodes() const {
    return {level, morton, firstChild, childCount, count, density, minDensity};
}

storage::Leaves Octree::leaves() const {
    return {leafNode, leafPointBegin, leafPointCount, leafDensity};
}

Result<Octree> assembleOctree(OctreePart part, Communicator& ranks) {
    return Assembly(std::move(part), ranks).run();
}

}  // namespace mote::prep
