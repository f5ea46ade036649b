// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <glm/gtc/type_ptr.hpp>
#include <glm/packing.hpp>

#include "server/render/egl/frame_gl.h"
#include "server/render/egl/frame_run.h"
#include "server/render/egl/frame_stage.h"

namespace mote::render {

// Hybrid volumes: what composite.comp reads of them, and their points.

bool FrameRun::prepareHybrids() {
    // The shades of all layers' normals come first.
    auto bricks = static_cast<std::uint32_t>(256 * plan_.hybrids.size());
    for (const auto& layer : plan_.hybrids) {
        const auto parts = hybridSteps_.of(layer, pacer_);
        if (!parts) return false;
        hybrids_.push_back({.plan = &layer,
                            .resident = parts->resident,
                            .bricks = parts->bricks,
                            .numbers = layer.hasPoints() ? splatNumbers(plan_, layer) : SplatNumbers{},
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
    std::vector<TableEntry> tables;
    std::array<HybridBlock, 8> blocks{};
    for (std::size_t i = 0; i < hybrids_.size(); ++i) {
        const HybridWork& work = hybrids_[i];
        const BrickLooks& bricks = *work.bricks;
        words.insert(words.end(), bricks.words.begin(), bricks.words.end());
        tables.insert(tables.end(), bricks.table.begin(), bricks.table.end());
        const StepHybrid& volume = work.resident->volume;
        blocks[i] = hybridBlock(plan_, *work.plan, volume.grid(), work.firstBrick);
    }
    buffers_.hybridBricks = GlBuffer::of(std::span<const std::uint32_t>(words));
    buffers_.hybridBricksTexture = bufferTexture(buffers_.hybridBricks, GL_R32UI);
    buffers_.hybridTables = GlBuffer::of(std::span<const TableEntry>(tables));
    buffers_.hybridTablesTexture = bufferTexture(buffers_.hybridTables, GL_RGBA32UI);
    buffers_.hybrids = GlBuffer(sizeof(blocks), blocks.data());
}

bool FrameRun::markSplats() {
    const Stage stage(*this, times_.pointsMark);
    for (std::size_t i = 0; i < hybrids_.size(); ++i) {
        if (!dispatchSplats("points_mark", i, {})) return false;
    }
    return true;
}

bool FrameRun::addSplats(const Pass& pass) {
    const Stage stage(*this, times_.pointsAdd);
    for (std::size_t i = 0; i < hybrids_.size(); ++i) {
        if (!dispatchSplats("splats_add", i, pass)) return false;
    }
    barrier();
    return true;
}

bool FrameRun::dispatchSplats(std::string_view name, std::size_t hybrid, const Pass& pass) {
    const HybridWork& work = hybrids_[hybrid];
    if (!work.drawsPoints()) return true;
    const HybridPlan& plan = *work.plan;
    StepSplats& splats = *work.resident->splats;
    splats.setLook(plan);
    const GLuint program = shaders_.program(name, {{"LAYERS", static_cast<unsigned>(layerCount())},
                                                   {"WORDS", words_},
                                                   {"SPLATS", 1U},
                                                   {"CELL", cellWords()},
                                                   {"SHAPE", static_cast<unsigned>(plan.style.pointShape)}});
    // Not every variant has every uniform; GL ignores what has no place (-1).
    const auto place = [program](const char* uniform) { return glGetUniformLocation(program, uniform); };
    const HybridBlock block = hybridBlock(plan_, plan, plan.step->points->size, 0);
    glUseProgram(program);
    glUniformMatrix4fv(place("toScreen"), 1, GL_FALSE, glm::value_ptr(work.numbers.toScreen));
    glUniform1ui(place("layer"), static_cast<GLuint>(layers_.size() + hybrid));
    glUniform1f(place("spacing"), work.numbers.spacing);
    glUniform1f(place("size"), static_cast<float>(plan.style.pointSize));
    glUniform1f(place("opacity"), static_cast<float>(plan.style.pointOpacity));
    glUniform3fv(place("gridSize"), 1, &block.grid.x);
    glUniform1i(place("clips"), block.place.y);
    glUniform4fv(place("clip"), HybridBlock::mostClips, &block.clips[0].x);
    glUniform1f(place("unit"), work.numbers.unit);
    glUniform2ui(place("pass"), pass.firstCell, pass.cells);
    glBindTextureUnit(pointUnit, splats.points());
    glBindTextureUnit(selectedUnit, splats.look());
    glBindTextureUnit(slabBitsUnit, buffers_.masksTexture.get());
    constexpr std::uint32_t piece = 1U << 20;  // points at once: few milliseconds' work
    const std::uint32_t count = plan.pointCount();
    glUniform2ui(place("stride"), plan.pointStride, splats.count());
    for (std::uint32_t first = 0; first < count; first += piece) {
        const std::uint32_t end = std::min(count, first + piece);
        glUniform2ui(place("range"), first, end);
        glDispatchCompute(groups(end - first, 256), 1, 1);
        if (!pacer_.next()) return false;
    }
    return true;
}

}  // namespace mote::render
