// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/resident_grids.h"

#include <algorithm>
#include <utility>

#include "protocol/scene/most_recent.h"

namespace mote::render {

std::optional<GridParts> ResidentGrids::of(const FieldPlan& plan, const CorrectedField& samples,
                                           const Pacer& pacer) {
    ResidentGrid* const resident = find(samples, pacer);
    if (resident == nullptr) return std::nullopt;
    using Classified = ResidentGrid::Classified;
    const auto& classified = mostRecent(
        resident->classified, keptClassified,
        [&](const Classified& one) { return one.transfer == plan.transfer && one.mixed == samples.mixed(); },
        [&] {
            return Classified{plan.transfer, samples.mixed(),
                              ClassifiedBricks(samples, sights_.of(plan, samples))};
        });
    return GridParts{resident, &classified.bricks};
}

ResidentGrid* ResidentGrids::find(const CorrectedField& samples, const Pacer& pacer) {
    // A new field may stand at the address of one that is gone: the weak pointers tell them apart.
    const auto same = [&](const ResidentGrid& one) {
        return one.key == samples.grid.get() && !one.grid.expired() && one.corrected == samples.corrected();
    };
    if (auto* const known = mostRecent(grids_, same)) return known;
    auto loaded = StepGrid::load(*samples.grid, samples.corrected(), pacer);
    if (!loaded) return nullptr;
    grids_.push_front(ResidentGrid{.grid = samples.grid,
                                   .key = samples.grid.get(),
                                   .corrected = samples.corrected(),
                                   .samples = *std::move(loaded)});
    return &grids_.front();
}

void ResidentGrids::dropExpired() {
    grids_.remove_if([](const ResidentGrid& one) { return one.grid.expired(); });
    sights_.dropExpired();
    std::uint64_t kept = 0;
    // What was drawn last stays whatever it takes.
    for (auto one = grids_.begin(); one != grids_.end();) {
        kept += one->bytes();
        one = one != grids_.begin() && kept > budget_ ? grids_.erase(one) : std::next(one);
    }
}

}  // namespace mote::render
