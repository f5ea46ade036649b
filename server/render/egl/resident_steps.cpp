// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/resident_steps.h"

#include <algorithm>

#include "protocol/scene/mote_check.h"

namespace mote::render {

ResidentStep& ResidentSteps::of(const std::shared_ptr<const storage::ParticleStep>& step) {
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    for (auto& resident : steps_) {
        if (resident.key == step.get() && !resident.step.expired()) return resident;
    }
    return steps_.emplace_back(
        ResidentStep{.step = step, .key = step.get(), .points = StepPoints(*step), .volume = {}});
}

const PointChunk& ResidentSteps::chunk(ResidentStep& resident, std::size_t index) {
    const auto step = resident.step.lock();
    MOTE_CHECK(step != nullptr);
    const bool fresh = !resident.points.resident(index);
    PointChunk& chunk = resident.points.load(*step, index);
    chunk.lastUse = ++uses_;
    if (fresh) makeRoom();
    return chunk;
}

const StepVolume* ResidentSteps::volume(ResidentStep& resident, const Pacer& pacer) {
    resident.volumeUse = ++uses_;
    if (!resident.volume) {
        const auto step = resident.step.lock();
        MOTE_CHECK(step != nullptr);
        resident.volume = StepVolume::load(*step, pacer);
    }
    return resident.volume ? &*resident.volume : nullptr;
}

void ResidentSteps::dropExpired() {
    steps_.remove_if([](const ResidentStep& resident) { return resident.step.expired(); });
    makeRoom();
}

std::uint64_t ResidentSteps::bytes() const {
    std::uint64_t total = 0;
    for (const auto& resident : steps_) {
        total += resident.volume ? resident.volume->bytes() : 0;
        for (std::size_t i = 0; i < resident.points.chunkCount(); ++i) {
            if (resident.points.resident(i)) total += resident.points.at(i)->bytes();
        }
    }
    return total;
}

void ResidentSteps::makeRoom() {
    // Volumes are small beside points and needed whole through a frame: only dropExpired() gives them up.
    for (std::uint64_t total = bytes(); total > budget_;) {
        ResidentStep* oldest = nullptr;
        std::size_t index = 0;
        std::uint64_t use = uses_;
        for (auto& resident : steps_) {
            for (std::size_t i = 0; i < resident.points.chunkCount(); ++i) {
                if (!resident.points.resident(i) || resident.points.at(i)->lastUse >= use) continue;
                oldest = &resident;
                index = i;
                use = resident.points.at(i)->lastUse;
            }
        }
        if (oldest == nullptr) return;
        total -= oldest->points.at(index)->bytes();
        oldest->points.evict(index);
    }
}

}  // namespace mote::render
