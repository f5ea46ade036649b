// SPDX-License-Identifier: GPL-3.0-or-later
//
// LeafCells: where the leaves of a step lie, a word each, so that a pass over the leaves reads them in their
// order and not the octree's nodes in any. Grown from the halo on as leaves are drawn. Owned by the device's
// ResidentLeaves; one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <vector>

#include "storage/particles/particle_step.h"

namespace mote::render {

/// A cell's place among the cells of its level, 16 bits each for x, y and z from bit 0, and its level.
using LeafCell = std::uint64_t;

/// Deeper cells than this do not fit.
inline constexpr unsigned deepestLeafLevel = 16;

constexpr std::uint32_t cellX(LeafCell cell) {
    return cell & 0xffff;
}
constexpr std::uint32_t cellY(LeafCell cell) {
    return cell >> 16 & 0xffff;
}
constexpr std::uint32_t cellZ(LeafCell cell) {
    return cell >> 32 & 0xffff;
}
constexpr std::uint32_t cellLevel(LeafCell cell) {
    return cell >> 48 & 0x1f;
}

class LeafCells {
  public:
    /// The cells of the first `count` leaves, which stay where they are. Uses all threads of the calling
    /// arena. Throws storage::StorageError where a leaf refers to a node that is not there or that lies too
    /// deep.
    std::span<const LeafCell> upTo(const storage::ParticleStep& step, std::size_t count);
    std::uint64_t bytes() const { return cells_.size() * sizeof(LeafCell); }

  private:
    std::vector<LeafCell> cells_;
};

/// The leaf cells of the steps in use. Holds no step alive.
class ResidentLeaves {
  public:
    /// The reference stays valid until dropExpired().
    LeafCells& of(const std::shared_ptr<const storage::ParticleStep>& step);
    void dropExpired();

  private:
    struct Entry {
        std::weak_ptr<const storage::ParticleStep> step;
        LeafCells cells;
    };
    std::list<Entry> entries_;
};

}  // namespace mote::render
