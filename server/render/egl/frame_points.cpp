// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <chrono>
#include <glm/gtc/type_ptr.hpp>

#include "server/render/egl/frame_run.h"

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

// Points: which slabs of which pixels hold some, room for them, and their sums.

bool FrameRun::markPoints() {
    const Stage stage(*this, times_.pointsMark);
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        if (!dispatchPoints("points_mark", i, {})) return false;
    }
    return true;
}

bool FrameRun::dispatchPoints(std::string_view name, std::size_t layer, const Pass& pass) {
    const LayerWork& work = layers_[layer];
    if (!work.drawsPoints()) return true;
    StepPoints& points = work.resident->points;
    points.select(*work.slot.points);
    for (std::size_t i = 0; i < points.chunkCount(); ++i) {
        const ChunkSelection& selection = points.selection(i);
        if (selection.empty()) continue;
        const PointChunk& chunk = steps_.chunk(*work.resident, i);
        glBindTextureUnit(pointUnit, chunk.pointsTexture.get());
        glBindTextureUnit(selectedUnit, chunk.selectedTexture.get());
        if (work.weighted()) glBindTextureUnit(weightUnitNumber, chunk.weightsTexture.get());
        if (selection.listed) {
            const auto count = static_cast<std::uint32_t>(selection.numbers.size());
            const GLuint program = usePointsProgram(name, layer, Selection::listed, pass);
            glUniform1ui(glGetUniformLocation(program, "listed"), count);
            glDispatchCompute(groups(count, StepPoints::blockPoints), 1, 1);
        } else {
            usePointsProgram(name, layer, Selection::whole, pass);
            dispatchBlocks(selection.wholeBlocks);
            usePointsProgram(name, layer, Selection::byLeaf, pass);
            dispatchBlocks(selection.partBlocks);
        }
        if (!pacer_.next()) return false;
    }
    return true;
}

void FrameRun::dispatchBlocks(const std::vector<std::uint32_t>& numbers) {
    if (numbers.empty()) return;
    const std::size_t bytes = numbers.size() * sizeof(std::uint32_t);
    buffers_.blocks.grow(bytes);
    buffers_.blocks.write(0, bytes, numbers.data());
    buffers_.blocks.bindStorage(blocks);
    glDispatchCompute(static_cast<GLuint>(numbers.size()), 1, 1);
}

GLuint FrameRun::usePointsProgram(std::string_view name, std::size_t layer, Selection selection,
                                  const Pass& pass) {
    const GLuint program = shaders_.program(name, {{"DISCS", layers_[layer].numbers.discs ? 1U : 0U},
                                                   {"FLAT", flat_ ? 1U : 0U},
                                                   {"SELECTION", static_cast<unsigned>(selection)},
                                                   {"WEIGHTS", layers_[layer].weighted() ? 1U : 0U}});
    setPointUniforms(program, layer, pass);
    glUseProgram(program);
    return program;
}

void FrameRun::setPointUniforms(GLuint program, std::size_t layer, const Pass& pass) const {
    const PointNumbers& numbers = layers_[layer].numbers;
    // Not every variant has every uniform; GL ignores what has no place (-1).
    const auto place = [program](const char* uniform) { return glGetUniformLocation(program, uniform); };
    glProgramUniformMatrix4fv(program, place("toScreen"), 1, GL_FALSE, glm::value_ptr(numbers.toScreen));
    glProgramUniform3uiv(program, place("origin"), 1, glm::value_ptr(numbers.origin));
    glProgramUniform1ui(program, place("layer"), static_cast<GLuint>(layer));
    glProgramUniform1f(program, place("nearest"), numbers.nearest);
    glProgramUniform1f(program, place("radius"), numbers.radius);
    glProgramUniform1f(program, place("unit"), static_cast<float>(numbers.unit));
    glProgramUniform1f(program, place("opacity"), numbers.opacity);
    glProgramUniform1f(program, place("inverseTau"), 1.0F / numbers.tau);
    glProgramUniform2ui(program, place("pass"), pass.firstCell, pass.cells);
    layers_[layer].bends.set(program);
}

FrameRun::Counts FrameRun::allocateCells(const Band& band) {
    const Stage stage(*this, times_.allocate);
    barrier();
    glUseProgram(allocateProgram());
    glBindTextureUnit(slabBitsUnit, buffers_.masksTexture.get());
    if (anyDots_) glBindTextureUnit(allocateDotsUnit, buffers_.dotListsTexture.get());
    glDispatchCompute(groups(band.tiles, 64), 1, 1);
    barrier();
    Counts counts;
    buffers_.counters.read(0, sizeof(counts), &counts);
    times_.cells += counts.cells;
    return counts;
}

bool FrameRun::addPoints(const Pass& pass) {
    const Stage stage(*this, times_.pointsAdd);
    if (!flat_) glBindTextureUnit(slabBitsUnit, buffers_.masksTexture.get());
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        if (!dispatchPoints("points_add", i, pass)) return false;
    }
    barrier();
    return true;
}

GLuint FrameRun::allocateProgram() const {
    return shaders_.program("cells_allocate",
                            {{"DOTS", anyDots_ ? 1U : 0U}, {"POINTS", anyPoints_ ? 1U : 0U}});
}

bool FrameRun::drawFlat(const Band& band) {
    const std::size_t bytes = std::size_t{band.tiles} * 64 * sizeof(std::uint32_t);
    buffers_.cells.grow(bytes);
    buffers_.cells.zero(bytes);
    buffers_.cells.bindStorage(cells);
    if (!addPoints({})) return false;
    ++times_.passes;
    return composite(shaders_.program("composite_flat", {{"COLORS", colors_.empty() ? 0U : 1U}}), 0,
                     band.tiles);
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
    if (anyDots_) {
        glBindTextureUnit(dotUnit, buffers_.dotsTexture.get());
        glBindTextureUnit(dotListUnit, buffers_.dotListsTexture.get());
    }
    if (!colors_.empty()) glBindTextureUnit(colorUnit, buffers_.colorsTexture.get());
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
    const auto steep = [](const GridWork& work) { return work.samples->gradient > 0.0; };
    const bool oneGrid = layers_.empty() && grids_.size() == 1 && !anyDots_;
    ShaderLibrary::Defines defines{{"LAYERS", static_cast<unsigned>(layerCount())},
                                   {"GRIDS", static_cast<unsigned>(grids_.size())},
                                   {"MIXED", std::any_of(grids_.begin(), grids_.end(), mixed) ? 1U : 0U},
                                   {"SLOPES", std::any_of(grids_.begin(), grids_.end(), steep) ? 1U : 0U},
                                   {"SECTIONS", plan_.sections.size() > 1 ? 2U : 1U}};
    if (!oneGrid) {
        defines.insert(defines.end(), {{"POINTS", points ? 1U : 0U},
                                       {"COLORS", points && !colors_.empty() ? 1U : 0U},
                                       {"DOTS", anyDots_ ? 1U : 0U},
                                       {"VOLUME", volume ? 1U : 0U},
                                       {"EXACT", plan_.samplesPerCell >= 2.0 ? 1U : 0U}});
    }
    const GLuint program = shaders_.program(oneGrid ? "composite_grid" : "composite", defines);
    glProgramUniform2ui(program, glGetUniformLocation(program, "pass"), pass.firstCell, pass.cells);
    return program;
}

}  // namespace mote::render
