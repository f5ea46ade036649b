// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/range_builder.h"

#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>

#include "protocol/base/mote_check.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

/// splitmix64 (Steele, Lea, Flood 2014): a row's place in the shuffle of its leaf, the same in every step. No
/// two rows have the same.
std::uint64_t shuffleHash(std::uint64_t row) {
    std::uint64_t h = row + 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    return h ^ (h >> 31);
}

/// Sorts on all threads. The calling thread takes up no other work while it waits: that may be another range,
/// with this builder.
template <class T, class Less>
void sortTogether(std::vector<T>& values, const Less& less) {
    tbb::this_task_arena::isolate([&] { tbb::parallel_sort(values.begin(), values.end(), less); });
}

unsigned bitsOf(std::uint64_t value) {
    return static_cast<unsigned>(std::bit_width(value));
}

}  // namespace

RangeTree RangeBuilder::build(std::span<const Particle> particles, const Weights& weights,
                              std::span<const PlanUnit> units, const RangeOptions& options) {
    // Cells of the octree and of the volume are told apart by the same keys.
    const unsigned keyLevel = std::max({options.octree.maxLevel, options.gridLevel, options.cellLevel});
    weights_ = weights;
    sort(particles, keyLevel);
    points_.resize(particles.size());
    RangeTree tree;
    if (options.octree.maxLevel > options.gridLevel) {
        tree.levels.resize(options.octree.maxLevel - options.gridLevel);
    }
    std::size_t begin = 0;
    for (const auto& unit : units) {
        if (unit.divided && options.octree.maxLevel > options.gridLevel) {
            tree.units.push_back(divide(begin, unit.count, tree, options, keyLevel));
        } else {
            tree.units.push_back({finishLeaf(begin, unit.count, unit.level), 0});
        }
        begin += unit.count;
    }
    MOTE_CHECK(begin == particles.size());
    tree.cells = sumCells(3 * (keyLevel - options.cellLevel));
    return tree;
}

/// Stable, so that particles of the same cell stay in the order of their rows.
void RangeBuilder::sort(std::span<const Particle> particles, unsigned keyLevel) {
    const std::size_t size = particles.size();
    keys_.resize(size);
    std::uint64_t all = 0;
    for (std::size_t i = 0; i < size; ++i) {
        keys_[i] = cellOf(particles[i], keyLevel);
        all |= keys_[i] ^ keys_[0];
    }
    // Key and index in one number, but for the leading bits that all keys share.
    const unsigned indexBits = bitsOf(size);
    const unsigned keyBits = bitsOf(all);
    std::vector<std::uint32_t> order;
    packed_.resize(size);
    if (indexBits + keyBits <= 64) {
        const std::uint64_t mask = keyBits == 64 ? ~0ULL : (1ULL << keyBits) - 1;
        for (std::size_t i = 0; i < size; ++i) packed_[i] = (keys_[i] & mask) << indexBits | i;
        radixSort(indexBits, keyBits);
        const std::uint64_t indexMask = (1ULL << indexBits) - 1;
        for (auto& item : packed_) item &= indexMask;
    } else {
        std::iota(packed_.begin(), packed_.end(), std::uint64_t{0});
        sortTogether(packed_, [&](std::uint64_t a, std::uint64_t b) {
            return keys_[a] != keys_[b] ? keys_[a] < keys_[b] : a < b;
        });
    }
    other_.resize(size);
    sorted_.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
        sorted_[i] = particles[packed_[i]];
        other_[i] = keys_[packed_[i]];
    }
    keys_.swap(other_);
    if (weights_.each.empty()) return;
    weightStore_.resize(size);
    for (std::size_t i = 0; i < size; ++i) weightStore_[i] = weights_.each[packed_[i]];
    weights_.each = weightStore_;
}

/// Sorts packed_ by its `bits` bits from `from` on, the least significant first.
void RangeBuilder::radixSort(unsigned from, unsigned bits) {
    // So many write positions fit the first-level cache and its address translation.
    constexpr unsigned mostDigitBits = 10;
    const unsigned passes = (bits + mostDigitBits - 1) / mostDigitBits;
    if (passes == 0) return;
    const unsigned digitBits = (bits + passes - 1) / passes;
    const std::uint64_t mask = (1ULL << digitBits) - 1;
    std::array<std::uint32_t, 1U << mostDigitBits> next{};
    other_.resize(packed_.size());
    for (unsigned pass = 0; pass < passes; ++pass) {
        const unsigned shift = from + pass * digitBits;
        next.fill(0);
        for (const auto item : packed_) ++next[item >> shift & mask];
        std::uint32_t at = 0;
        for (auto& count : next) at += std::exchange(count, at);
        for (const auto item : packed_) other_[next[item >> shift & mask]++] = item;
        packed_.swap(other_);
    }
}

std::vector<CellSum> RangeBuilder::sumCells(unsigned shift) const {
    std::vector<CellSum> cells;
    for (std::size_t i = 0; i < keys_.size();) {
        const std::uint64_t cell = keys_[i] >> shift;
        double sum = 0.0;
        for (; i < keys_.size() && keys_[i] >> shift == cell; ++i) sum += weights_[i];
        cells.push_back({sum, cell});
    }
    return cells;
}

UnitTree RangeBuilder::divide(std::size_t begin, std::size_t count, RangeTree& tree,
                              const RangeOptions& options, unsigned keyLevel) {
    UnitTree unit;
    std::vector<Node> full{{begin, count, 0}};
    for (std::size_t depth = 0; depth < tree.levels.size() && !full.empty(); ++depth) {
        const auto level = static_cast<unsigned>(options.gridLevel + 1 + depth);
        const bool last = level == options.octree.maxLevel;
        auto& nodes = tree.levels[depth];
        std::vector<Node> next;
        for (const auto& node : full) {
            auto& mask = depth == 0 ? unit.children : tree.levels[depth - 1].children[node.index];
            const auto at = split(node, 3 * (keyLevel - level));
            for (std::size_t child = 0; child < 8; ++child) {
                const std::size_t particles = at[child + 1] - at[child];
                if (particles == 0) continue;
                mask |= static_cast<std::uint8_t>(1U << child);
                nodes.add(static_cast<std::uint32_t>(particles));
                if (particles > options.octree.leafCapacity && !last) {
                    next.push_back({at[child], particles, nodes.size() - 1});
                } else {
                    nodes.weight.back() = finishLeaf(at[child], particles, level);
                }
            }
        }
        full.swap(next);
    }
    return unit;
}

/// Where the children of a cell begin, whose number stands in its keys from bit `shift` on.
RangeBuilder::Split RangeBuilder::split(const Node& node, unsigned shift) const {
    Split result{};
    std::array<std::size_t, 8> counts{};
    for (std::size_t i = node.begin; i < node.begin + node.count; ++i) ++counts[keys_[i] >> shift & 7U];
    result[0] = node.begin;
    for (std::size_t child = 0; child < 8; ++child) result[child + 1] = result[child] + counts[child];
    return result;
}

double RangeBuilder::finishLeaf(std::size_t begin, std::size_t count, unsigned level) {
    double weight = 0.0;
    for (std::size_t i = begin; i < begin + count; ++i) weight += weights_[i];
    shuffle(begin, count);
    const unsigned shift = 16U - level;  // the 16 bits below the leaf's own
    for (std::size_t i = 0; i < count; ++i) {
        const auto& particle = sorted_[shuffled_[i].particle];
        const auto bits = [&](std::uint32_t place) { return static_cast<std::uint16_t>(place >> shift); };
        points_[begin + i] = {{bits(particle.x), bits(particle.y), bits(particle.z)}, 0, particle.row, 0};
    }
    return weight;
}

void RangeBuilder::shuffle(std::size_t begin, std::size_t count) {
    shuffled_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        shuffled_[i] = {shuffleHash(sorted_[begin + i].row), static_cast<std::uint32_t>(begin + i)};
    }
    constexpr std::size_t many = 65536;
    if (count > many) {
        sortTogether(shuffled_, std::less<>());
    } else {
        std::sort(shuffled_.begin(), shuffled_.end());
    }
}

void addCells(std::span<const CellSum> cells, unsigned cellLevel, unsigned level, std::vector<double>& sums) {
    for (const auto& one : cells) sums[one.cell >> (3 * (cellLevel - level))] += one.weight;
}

std::vector<float> densityVolume(const std::vector<double>& sums, unsigned level) {
    const std::size_t size = std::size_t{1} << level;
    std::vector<float> volume(sums.size());
    for (std::size_t cell = 0; cell < sums.size(); ++cell) {
        if (sums[cell] == 0.0) continue;
        const auto at = mortonCell(cell);
        volume[(at[2] * size + at[1]) * size + at[0]] =
            static_cast<float>(std::ldexp(sums[cell], static_cast<int>(3 * level)));
    }
    return volume;
}

void addToHistogram(std::span<const float> density, std::span<const std::uint32_t> particles,
                    const LogDensity& scale, std::vector<std::uint64_t>& bins) {
    constexpr std::size_t count = storage::densityHistogramBins;
    bins.resize(count);
    for (std::size_t i = 0; i < density.size(); ++i) {
        // A density of zero has no logarithm; it belongs to the thinnest.
        const double t = density[i] > 0.0F ? scale.ofLeaf(density[i]) : 0.0;
        bins[std::min(count - 1, static_cast<std::size_t>(t * count))] += particles[i];
    }
}

}  // namespace mote::prep
