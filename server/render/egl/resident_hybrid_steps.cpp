// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/resident_hybrid_steps.h"

#include <algorithm>
#include <utility>

namespace mote::render {
namespace {

std::vector<std::uint32_t> visibleOf(const glm::uvec3& count, const std::vector<std::uint32_t>& words) {
    std::vector<std::uint32_t> visible;
    std::size_t i = 0;
    for (std::uint32_t z = 0; z < count.z; ++z) {
        for (std::uint32_t y = 0; y < count.y; ++y) {
            for (std::uint32_t x = 0; x < count.x; ++x, ++i) {
                if ((words[i] & 0x80000000U) != 0) visible.push_back(x | y << 10 | z << 20);
            }
        }
    }
    return visible;
}

}  // namespace

ResidentHybrid* ResidentHybridSteps::of(const HybridPlan& plan, const TransferTable& table,
                                        const Pacer& pacer) {
    ResidentHybrid* const resident = find(plan, pacer);
    if (resident == nullptr) return nullptr;
    if (plan.hasPoints() && !resident->splats) resident->splats.emplace(*plan.step);
    if (resident->transfer == plan.transfer) return resident;
    resident->brickWords = resident->volume.brickWords(table);
    resident->visible = visibleOf(resident->volume.brickCount(), resident->brickWords);
    resident->transfer = plan.transfer;
    return resident;
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
                                       .volume = *std::move(volume),
                                       .splats = std::nullopt,
                                       .transfer = std::nullopt});
    return &hybrids_.front();
}

void ResidentHybridSteps::dropExpired() {
    hybrids_.remove_if([](const ResidentHybrid& one) { return one.step.expired(); });
    std::uint64_t kept = 0;
    // What was drawn last stays whatever it takes.
    for (auto one = hybrids_.begin(); one != hybrids_.end();) {
        kept += one->bytes();
        one = one != hybrids_.begin() && kept > budget_ ? hybrids_.erase(one) : std::next(one);
    }
}

}  // namespace mote::render
