// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <glm/packing.hpp>

#include "server/render/egl/frame_gl.h"
#include "server/render/egl/frame_run.h"

namespace mote::render {

// Fields of samples: what composite.comp reads of them.

bool FrameRun::prepareGrids() {
    // The shades of all layers' normals come first.
    auto bricks = static_cast<std::uint32_t>(256 * (plan_.fields.size() - plan_.densities()));
    for (std::size_t i = plan_.densities(); i < plan_.fields.size(); ++i) {
        const FieldPlan& field = plan_.fields[i];
        const auto parts = residentGrids_.of(field, *field.grid(), pacer_);
        if (!parts) return false;
        grids_.push_back({.plan = &field,
                          .samples = field.grid(),
                          .resident = parts->resident,
                          .bricks = parts->bricks,
                          .visible = GlBuffer::of(std::span<const std::uint32_t>(parts->bricks->visible)),
                          .visibleCount = static_cast<std::uint32_t>(parts->bricks->visible.size()),
                          .firstBrick = bricks});
        bricks += static_cast<std::uint32_t>(parts->bricks->words.size());
    }
    if (!grids_.empty()) gatherBricks();
    return pacer_.next();
}

/// Shades, the bricks of one layer after the other, and what the shaders know of the layers.
void FrameRun::gatherBricks() {
    std::vector<std::uint32_t> words;
    for (const auto& work : grids_) {
        for (const auto& shade : work.samples->shades)
            words.push_back(glm::packUnorm2x16({shade.diffuse, shade.specular}));
    }
    std::array<GridBlock, 8> blocks{};
    for (std::size_t i = 0; i < grids_.size(); ++i) {
        const GridWork& work = grids_[i];
        const ClassifiedBricks& bricks = *work.bricks;
        words.insert(words.end(), bricks.words.begin(), bricks.words.end());
        blocks[i] =
            gridBlock(plan_, *work.plan, *work.samples, work.resident->samples.grid(), work.firstBrick);
    }
    buffers_.gridBricks = GlBuffer::of(std::span<const std::uint32_t>(words));
    buffers_.gridBricksTexture = bufferTexture(buffers_.gridBricks, GL_R32UI);
    buffers_.grids = GlBuffer(sizeof(blocks), blocks.data());
}

}  // namespace mote::render
