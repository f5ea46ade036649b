// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_run.h"

#include <algorithm>
#include <chrono>

#include "server/render/egl/frame_gl.h"
#include "server/render/egl/frame_stage.h"

namespace mote::render {
namespace {

/// How many tiles to draw at once: a few milliseconds' work on any device, so that a newer view need not wait
/// and a fast device is kept busy.
class TileBatch {
  public:
    std::uint32_t size() const { return size_; }
    /// Called after each batch.
    void done() {
        const auto now = std::chrono::steady_clock::now();
        const auto took = now - start_;
        if (took < std::chrono::milliseconds(4)) size_ = std::min(2 * size_, 16384U);
        if (took > std::chrono::milliseconds(12)) size_ = std::max(size_ / 2, 64U);
        start_ = now;
    }

  private:
    std::uint32_t size_ = 256;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

bool FrameRun::drawFlat(const Band& band) {
    const std::size_t bytes = std::size_t{band.tiles} * 64 * sizeof(std::uint32_t);
    buffers_.cells.grow(bytes);
    buffers_.cells.zero(bytes);
    buffers_.cells.bindStorage(cells);
    if (!addPoints({})) return false;
    ++times_.passes;
    return composite(shaders_.program("composite_flat", {}), 0, band.tiles);
}

bool FrameRun::drawCells(const Band& band, const Counts& counts) {
    // A pixel belongs to the pass in which its first cell lies; its others may reach beyond by the margin.
    const std::uint64_t margin = layerCount() * plan_.slabs;
    constexpr std::uint64_t cellSize = 2 * sizeof(std::uint32_t);  // weight and moment
    const std::uint64_t limit = pairLimit(options_.cellBytes) / cellSize;
    const std::uint64_t capacity = std::min<std::uint64_t>(std::max(limit, 2 * margin) - margin, 1U << 30);
    buffers_.cells.grow((std::min<std::uint64_t>(counts.cells, capacity) + margin) * cellSize);
    buffers_.cells.bindStorage(cells);
    buffers_.cellsTexture = bufferTexture(buffers_.cells, GL_RG32UI);
    for (std::uint64_t first = 0; first <= counts.cells; first += capacity) {
        const auto present = static_cast<std::uint32_t>(std::min(counts.cells - first, capacity) + margin);
        const auto firstCell = static_cast<std::uint32_t>(first);
        if (counts.cells > 0) {
            buffers_.cells.zero(present * cellSize);
            if (!addPoints({firstCell, present})) return false;
        }
        const Pass pass{firstCell, static_cast<std::uint32_t>(capacity)};
        if (!composite(compositeProgram(true, false, pass), 0, counts.tiles[0])) return false;
        const std::uint32_t volumeTiles =
            first == 0 ? counts.tiles[1] : 0;  // they have no cells: once is enough
        if (!composite(compositeProgram(false, true, pass), band.tiles, volumeTiles)) return false;
        if (!composite(compositeProgram(true, true, pass), 2 * band.tiles, counts.tiles[2])) return false;
        ++times_.passes;
    }
    return true;
}

bool FrameRun::composite(GLuint program, std::uint32_t firstTile, std::uint32_t tileCount) {
    const Stage stage(*this, times_.composite);
    glUseProgram(program);
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const LayerWork& work = layers_[i];
        const auto unit = static_cast<GLuint>(i);
        glBindTextureUnit(unit, work.volume == nullptr ? buffers_.noVolume.get() : work.volume->texture());
    }
    for (std::size_t i = 0; i < grids_.size(); ++i)
        glBindTextureUnit(static_cast<GLuint>(layers_.size() + i), grids_[i].resident->samples.samples());
    if (!grids_.empty()) {
        glBindTextureUnit(gridBrickUnit, buffers_.gridBricksTexture.get());
        glBindBufferBase(GL_UNIFORM_BUFFER, 1, buffers_.grids.get());
    }
    glBindTextureUnit(tableUnit, buffers_.tablesTexture.get());
    glBindTextureUnit(maskUnit, buffers_.masksTexture.get());
    glBindTextureUnit(cellUnit, buffers_.cellsTexture.get());
    glBindTextureUnit(volumeMaskUnit, buffers_.volumeMasksTexture.get());
    if (!dots_.empty()) {
        glBindTextureUnit(dotUnit, buffers_.dotsTexture.get());
        glBindTextureUnit(dotListUnit, buffers_.dotListsTexture.get());
    }
    if (plan_.sections.size() > 1) buffers_.sections.bindStorage(sections);
    barrier();
    TileBatch batch;
    for (std::uint32_t tile = 0, count = 0; tile < tileCount; tile += count) {
        count = std::min(batch.size(), tileCount - tile);
        glUniform1ui(0, firstTile + tile);
        glDispatchCompute(count, 1, 1);
        if (!pacer_.next()) return false;
        batch.done();
    }
    barrier();
    return true;
}

GLuint FrameRun::compositeProgram(bool points, bool volume, const Pass& pass) const {
    const auto mixed = [](const GridWork& work) { return work.samples->mixed(); };
    const bool oneGrid = layers_.empty() && grids_.size() == 1 && dots_.empty();
    ShaderLibrary::Defines defines{{"LAYERS", static_cast<unsigned>(layerCount())},
                                   {"GRIDS", static_cast<unsigned>(grids_.size())},
                                   {"MIXED", std::any_of(grids_.begin(), grids_.end(), mixed) ? 1U : 0U},
                                   {"SECTIONS", plan_.sections.size() > 1 ? 2U : 1U}};
    if (!oneGrid) {
        defines.insert(defines.end(), {{"POINTS", points ? 1U : 0U},
                                       {"DOTS", dots_.empty() ? 0U : 1U},
                                       {"VOLUME", volume ? 1U : 0U},
                                       {"EXACT", plan_.samplesPerCell >= 2.0 ? 1U : 0U}});
    }
    const GLuint program = shaders_.program(oneGrid ? "composite_grid" : "composite", defines);
    glProgramUniform2ui(program, glGetUniformLocation(program, "pass"), pass.firstCell, pass.cells);
    return program;
}

}  // namespace mote::render
