// SPDX-License-Identifier: GPL-3.0-or-later
//
// IdSet: ids of particles, and the points of a step that have them, by the index that lies beside its points.
// Values and functions without state; functions that take columns use all threads of the calling arena, and
// throw StorageError.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "storage/numbers/point_mask.h"
#include "storage/particles/particle_columns.h"

namespace mote::storage {

class IdSet {
  public:
    /// Ascending, without repetition.
    explicit IdSet(std::vector<std::uint64_t> ids);
    /// The ids of the chosen points of a step that has ids. Nothing where `cancelled` says so.
    static std::optional<IdSet> of(const PointMask& mask, const ParticleColumns& columns,
                                   const std::function<bool()>& cancelled);

    bool contains(std::uint64_t id) const;
    std::uint64_t size() const { return size_; }
    /// All of them, ascending.
    std::vector<std::uint64_t> list() const;

  private:
    IdSet() = default;

    std::uint64_t size_ = 0;
    std::vector<std::uint64_t> ids_;  // ascending; or, of many that lie close:
    std::uint64_t first_ = 0;         // the id of the first bit
    std::vector<std::uint64_t> bits_;
};

/// The points whose ids are in the set. Nothing where `cancelled` says so.
std::optional<PointMask> pointsOf(const IdSet& ids, const ParticleColumns& columns,
                                  const std::function<bool()>& cancelled);

/// For each of the ids, which ascend, the first of its points; none where the step lacks it. Nothing where
/// `cancelled` says so.
inline constexpr std::uint32_t noPoint = 0xFFFFFFFFU;
std::optional<std::vector<std::uint32_t>> firstPoints(std::span<const std::uint64_t> ids,
                                                      const ParticleColumns& columns,
                                                      const std::function<bool()>& cancelled);

}  // namespace mote::storage
