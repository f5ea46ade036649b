// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/resident_hybrid_steps.h"

#include <algorithm>
#include <utility>

#include "server/render/plan/latest.h"

namespace mote::render {
std::optional<HybridParts> ResidentHybridSteps::of(const HybridPlan& plan, const Pacer& pacer) {
    ResidentHybrid* const resident = find(plan, pacer);
    if (resident == nullptr) return std::nullopt;
    const auto& looks = latest(
        resident->looks, keptLooks,
        [&](const ResidentHybrid::Looks& one) {
            return one.transfer == plan.transfer && one.mixed == plan.mixed();
        },
        [&] {
            return ResidentHybrid::Looks{plan.transfer, plan.mixed(), BrickLooks(plan, looks_.of(plan))};
        });
    return HybridParts{resident, &looks.bricks};
}

ResidentHybrid* ResidentHybridSteps::find(const HybridPlan& plan, const Pacer& pacer) {
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    const auto found = std::find_if(hybrids_.begin(), hybrids_.end(), [&](const ResidentHybrid& one) {
        return one.key == plan.step.get() && !one.step.expired() && one.corrected == plan.corrected();
    });
    if (found != hybrids_.end()) {
        hybrids_.splice(hybrids_.begin(), hybrids_, found);
        return &hybrids_.front();
    }
    auto volume = StepHybrid::load(*plan.step, plan.corrected(), pacer);
    if (!volume) return nullptr;
    hybrids_.push_front(ResidentHybrid{.step = plan.step,
                                       .key = plan.step.get(),
                                       .corrected = plan.corrected(),
                                       .volume = *std::move(volume)});
    return &hybrids_.front();
}

void ResidentHybridSteps::dropExpired() {
    hybrids_.remove_if([](const ResidentHybrid& one) { return one.step.expired(); });
    looks_.dropExpired();
    std::uint64_t kept = 0;
    // What was drawn last stays whatever it takes.
    for (auto one = hybrids_.begin(); one != hybrids_.end();) {
        kept += one->bytes();
        one = one != hybrids_.begin() && kept > budget_ ? hybrids_.erase(one) : std::next(one);
    }
}

}  // namespace mote::render
