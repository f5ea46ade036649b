// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/recorded_moves.h"

namespace mote::prep {

void storeMoves(const RecordedMoves& moves, storage::StippleHierarchy& hierarchy) {
    auto& h = hierarchy;
    h.movesBegin.assign(h.size() + 1, 0);
    for (const auto& move : moves) ++h.movesBegin[move.point + 1];
    for (std::size_t i = 0; i < h.size(); ++i) h.movesBegin[i + 1] += h.movesBegin[i];
    auto next = h.movesBegin;
    h.moveNeighbour.resize(moves.size());
    h.movePosition.resize(moves.size());
    for (const auto& move : moves) {
        const auto at = next[move.point]++;
        h.moveNeighbour[at] = move.neighbour;
        h.movePosition[at] = move.position;
    }
}

}  // namespace mote::prep
