// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/modalities.h"

#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {

std::vector<Direction> directionsOf(const Raster<float>& angles, const std::stop_token& stop) {
    auto made = listInTurns<Direction>(angles.values.size());
    forInTurns(std::uint32_t{0}, angles.height, [&](std::uint32_t row) {
        if (isStopped(stop)) return;
        const std::size_t first = angles.index(0, row);
        for (std::size_t i = first; i < first + angles.width; ++i) made[i] = directionOf(angles.values[i]);
    });
    return made;
}

}  // namespace mote::render
