// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_run.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "server/render/egl/frame_gl.h"
#include "server/render/egl/frame_stage.h"

namespace mote::render {

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
                                                   {"SELECTION", static_cast<unsigned>(selection)}});
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
    if (!dots_.empty()) glBindTextureUnit(allocateDotsUnit, buffers_.dotListsTexture.get());
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
                            {{"DOTS", dots_.empty() ? 0U : 1U}, {"POINTS", anyPoints_ ? 1U : 0U}});
}

}  // namespace mote::render
