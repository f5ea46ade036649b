// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <glm/packing.hpp>

#include "server/render/egl/frame_gl.h"
#include "server/render/egl/frame_run.h"

namespace mote::render {

// Hybrid volumes: what composite.comp reads of them.

bool FrameRun::prepareHybrids() {
    // The shades of all layers' normals come first.
    auto bricks = static_cast<std::uint32_t>(256 * plan_.hybrids.size());
    for (const auto& layer : plan_.hybrids) {
        const auto parts = hybridSteps_.of(layer, pacer_);
        if (!parts) return false;
        hybrids_.push_back({.plan = &layer,
                            .resident = parts->resident,
                            .bricks = parts->bricks,
                            .visible = GlBuffer::of(std::span<const std::uint32_t>(parts->bricks->visible)),
                            .visibleCount = static_cast<std::uint32_t>(parts->bricks->visible.size()),
                            .firstBrick = bricks});
        bricks += static_cast<std::uint32_t>(parts->bricks->words.size());
    }
    if (!hybrids_.empty()) gatherBricks();
    return pacer_.next();
}

/// Shades, the bricks of one layer after the other, and what the shaders know of the layers.
void FrameRun::gatherBricks() {
    std::vector<std::uint32_t> words;
    for (const auto& work : hybrids_) {
        for (const auto& shade : work.plan->light.shades())
            words.push_back(glm::packUnorm2x16({shade.diffuse, shade.specular}));
    }
    std::array<HybridBlock, 8> blocks{};
    for (std::size_t i = 0; i < hybrids_.size(); ++i) {
        const HybridWork& work = hybrids_[i];
        const BrickLooks& bricks = *work.bricks;
        words.insert(words.end(), bricks.words.begin(), bricks.words.end());
        const StepHybrid& volume = work.resident->volume;
        blocks[i] = hybridBlock(plan_, *work.plan, volume.grid(), work.firstBrick);
    }
    buffers_.hybridBricks = GlBuffer::of(std::span<const std::uint32_t>(words));
    buffers_.hybridBricksTexture = bufferTexture(buffers_.hybridBricks, GL_R32UI);
    buffers_.hybrids = GlBuffer(sizeof(blocks), blocks.data());
}

}  // namespace mote::render
