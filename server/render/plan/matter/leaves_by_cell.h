// SPDX-License-Identifier: GPL-3.0-or-later
//
// LeavesByCell: the leaves of a step in the order of their cells, by which sums over cells are made on all
// threads of the calling arena: leaves lie by density, their nodes by level and place. A value; it holds no
// step alive. Its functions are pure.
#pragma once

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "server/render/plan/matter/cell_grid.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

class LeavesByCell {
  public:
    explicit LeavesByCell(const storage::ParticleStep& step) : nodes_(step.nodes()) {
        if (step.leaves().size() == 0) return;
        for (unsigned level = 0; level < begins_.size(); ++level) {
            const auto at = std::lower_bound(nodes_.level.begin(), nodes_.level.end(), level);
            begins_[level] = static_cast<std::size_t>(at - nodes_.level.begin());
        }
    }

    /// Calls visit(leaf, CellAt) for all leaves of levels from `first` to `last`, level by level. Those that
    /// lie in one cell of level `cells` are visited by one thread, one after the other in the order of their
    /// places: sums in such cells are the same on any number of threads.
    template <class Visit>
    void forEach(unsigned cells, unsigned first, unsigned last, const Visit& visit) const {
        for (unsigned level = first; level <= std::min<unsigned>(last, deepestLevel); ++level) {
            const std::size_t begin = begins_[level], size = begins_[level + 1] - begin;
            const unsigned within = level > cells ? 3 * (level - cells) : 0;
            // The first node from `at` on that lies in another cell than the one before it.
            const auto edge = [&](std::size_t at) {
                if (at == begin) return at;
                const auto rest = nodes_.morton.subspan(at, begin + size - at);
                const std::uint64_t cell = nodes_.morton[at - 1] >> within;
                const auto next = std::partition_point(
                    rest.begin(), rest.end(), [&](std::uint64_t morton) { return morton >> within == cell; });
                return at + static_cast<std::size_t>(next - rest.begin());
            };
            tbb::parallel_for(std::size_t{0}, (size + grain - 1) / grain, [&](std::size_t part) {
                const std::size_t end = edge(begin + std::min((part + 1) * grain, size));
                for (std::size_t node = edge(begin + part * grain); node < end; ++node) {
                    if (nodes_.childCount[node] == 0)
                        visit(std::size_t{nodes_.firstChild[node]},
                              CellAt(nodes_.level[node], nodes_.morton[node]));
                }
            });
        }
    }
    /// The same for all leaves.
    template <class Visit>
    void forEach(unsigned cells, const Visit& visit) const {
        forEach(cells, 0, deepestLevel, visit);
    }

  private:
    static constexpr std::size_t grain = 8192;  // nodes

    const storage::OctreeNodes nodes_;
    std::array<std::size_t, deepestLevel + 2> begins_{};  // by level: its first node, or where it would lie
};

}  // namespace mote::render
