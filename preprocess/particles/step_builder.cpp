// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_builder.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>

#include "preprocess/particles/density_volume.h"
#include "preprocess/particles/morton.h"
#include "preprocess/particles/radix_sort.h"

namespace mote::prep {
namespace {

Error cancelledError() {
    return {ErrorCode::cancelled, "", "cancelled"};
}

/// splitmix64 (Steele, Lea, Flood 2014): a row's place in the shuffle of its leaf, the same in every step.
std::uint64_t shuffleHash(std::uint64_t row) {
    std::uint64_t h = row + 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    return h ^ (h >> 31);
}

/// Particles in Morton order, those of the same cell in the order of their rows.
KeyedIndices sortedKeys(const QuantizedStep& particles, unsigned keyLevel) {
    KeyedIndices items;
    items.key.resize(particles.size());
    items.index.resize(particles.size());
    const unsigned shift = 32 - keyLevel;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, particles.size(), 1 << 14), [&](const auto& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            const auto& place = particles.place[i];
            items.key[i] = mortonKey(place[0] >> shift, place[1] >> shift, place[2] >> shift);
            items.index[i] = static_cast<std::uint32_t>(i);
        }
    });
    radixSort(items, 3 * keyLevel);
    return items;
}

std::vector<double> gathered(const std::vector<double>& values, const std::vector<std::uint32_t>& order) {
    std::vector<double> result(order.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), 1 << 14), [&](const auto& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) result[i] = values[order[i]];
    });
    return result;
}

/// Puts points in the order of their leaves, shuffled within each.
class PointWriter {
  public:
    PointWriter(const QuantizedStep& particles, const std::vector<std::uint32_t>& order, BuiltStep& built)
        : particles_(particles), order_(order), built_(built) {
        built_.position.resize(order.size());
        built_.row.resize(order.size());
    }

    bool run(const std::function<bool()>& cancelled) {
        const std::size_t leaves = built_.octree.leafNode.size();
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves, 256), [&](const auto& part) {
            std::vector<Item> items;
            for (std::size_t leaf = part.begin(); leaf < part.end(); ++leaf) {
                if ((leaf - part.begin()) % 4096 == 0 && cancelled()) return;
                write(leaf, items);
            }
        });
        return !cancelled();
    }

  private:
    struct Item {
        std::uint64_t hash;
        std::uint32_t particle;
        bool operator<(const Item& other) const {
            return hash != other.hash ? hash < other.hash : particle < other.particle;
        }
    };

    void write(std::size_t leaf, std::vector<Item>& items) {
        const auto& tree = built_.octree;
        const std::size_t count = tree.leafPointCount[leaf];
        items.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto particle = order_[tree.leafSource[leaf] + i];
            items[i] = {shuffleHash(particles_.row[particle]), particle};
        }
        if (count > 65536) {
            tbb::parallel_sort(items.begin(), items.end());
        } else {
            std::sort(items.begin(), items.end());
        }
        // The 16 bits below the leaf's own.
        const unsigned shift = 16U - tree.level[tree.leafNode[leaf]];
        for (std::size_t i = 0; i < count; ++i) {
            const auto& place = particles_.place[items[i].particle];
            const auto bits = [&](std::size_t axis) {
                return static_cast<std::uint16_t>(place[axis] >> shift);
            };
            built_.position[tree.leafPointBegin[leaf] + i] = {bits(0), bits(1), bits(2)};
            built_.row[tree.leafPointBegin[leaf] + i] = particles_.row[items[i].particle];
        }
    }

    const QuantizedStep& particles_;
    const std::vector<std::uint32_t>& order_;
    BuiltStep& built_;
};

}  // namespace

storage::StepContent BuiltStep::content() const {
    storage::StepContent content;
    content.totalWeight = octree.totalWeight;
    content.nodes = octree.nodes();
    content.leaves = octree.leaves();
    content.positions = position;
    content.rows = row;
    content.volume = volume;
    content.volumeSize = volumeSize;
    content.previewPoints = preview.points;
    content.previewThreshold = preview.threshold;
    return content;
}

std::uint64_t buildMemory(std::uint64_t particles, const StepOptions& options) {
    // Arrays of particles; nodes and leaves, of which there are more the smaller the leaves; the volume; the
    // program.
    const std::uint64_t tree = 160 * particles / options.octree.leafCapacity;
    return 56 * particles + tree + (std::uint64_t{4} << (3 * options.volumeLevel)) +
           (std::uint64_t{64} << 20);
}

Result<BuiltStep> buildStep(QuantizedStep particles, const StepOptions& options,
                            const std::function<bool()>& cancelled) {
    const unsigned keyLevel = std::max(options.octree.maxLevel, options.volumeLevel);
    auto sorted = sortedKeys(particles, keyLevel);
    if (cancelled()) return cancelledError();
    auto weights = gathered(particles.weight, sorted.index);
    particles.weight = std::vector<double>();  // "= {}" would keep the memory
    auto octree = buildOctree(sorted.key, weights, keyLevel, options.octree);
    if (!octree.ok()) return octree.error();
    BuiltStep built;
    built.octree = *std::move(octree);
    built.volumeSize = 1U << options.volumeLevel;
    built.volume = densityVolume(sorted.key, weights, keyLevel, options.volumeLevel);
    weights = std::vector<double>();
    sorted.key = std::vector<std::uint64_t>();
    if (!PointWriter(particles, sorted.index, built).run(cancelled)) return cancelledError();
    particles = {};
    built.preview = buildPreview(built.octree.nodes(), built.octree.leaves(), built.position);
    return built;
}

}  // namespace mote::prep
