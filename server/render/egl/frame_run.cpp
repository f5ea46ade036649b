// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_run.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

namespace mote::render {
namespace {

// Bindings of shader storage, as the shaders say.
enum Storage : GLuint { masks, offsets, cells, blocks, counters, volumeMasks, bricks, pixels, tiles };
constexpr GLuint transferUnits = 8;  // texture units: 0 to 7 volumes, from here transfer tables
constexpr std::uint32_t tilesAtOnce = 512;
constexpr std::size_t cellSize = 2 * sizeof(std::uint32_t);

void barrier() {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

std::uint64_t storageLimit() {
    GLint64 limit = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    return static_cast<std::uint64_t>(std::max<GLint64>(limit, 1 << 24));
}

std::uint32_t groups(std::uint32_t invocations, std::uint32_t size) {
    return (invocations + size - 1) / size;
}

}  // namespace

/// Notes how long a stage took, where that is wanted.
class FrameRun::Stage {
  public:
    Stage(const FrameRun& run, StageTimes::Duration& sum) : measure_(run.options_.measure), sum_(sum) {
        if (measure_) glFinish();
    }
    ~Stage() {
        if (!measure_) return;
        glFinish();
        sum_ += std::chrono::steady_clock::now() - start_;
    }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

  private:
    bool measure_;
    StageTimes::Duration& sum_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

FrameRun::FrameRun(const FramePlan& plan, PixelFormat format, const EglOptions& options,
                   ShaderLibrary& shaders, ResidentSteps& steps, TransferTextures& transfers,
                   FrameBuffers& buffers, std::stop_token stop)
    : plan_(plan),
      format_(format),
      options_(options),
      shaders_(shaders),
      steps_(steps),
      transfers_(transfers),
      buffers_(buffers),
      pacer_(std::move(stop)),
      words_(groups(plan.slabs, 32)),
      tilesAcross_(groups(plan.width, 8)),
      tilesDown_(groups(plan.height, 8)) {}

std::optional<Picture> FrameRun::draw() {
    if (!prepare()) return std::nullopt;
    Picture picture{.width = plan_.width, .height = plan_.height, .format = format_, .pixels = {}};
    picture.pixels.resize(std::size_t{plan_.width} * plan_.height * bytesPerPixel(format_));
    for (const auto& layer : plan_.layers) picture.pointsDrawn += layer.pointsDrawn;
    const std::uint64_t rowBytes =
        std::uint64_t{tilesAcross_} * 64 * layers_.size() * words_ * sizeof(std::uint32_t);
    const std::uint64_t rows =
        std::max<std::uint64_t>(std::min(options_.maskBytes, storageLimit()) / rowBytes, 1);
    for (std::uint32_t row = 0; row < tilesDown_; row += static_cast<std::uint32_t>(rows)) {
        const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(rows, tilesDown_ - row));
        if (!drawBand({row, count, count * tilesAcross_}, picture)) return std::nullopt;
        ++times_.bands;
    }
    checkGl("a picture");
    return picture;
}

bool FrameRun::prepare() {
    const Stage stage(*this, times_.prepare);
    for (const auto& layer : plan_.layers) {
        layers_.push_back(LayerWork{.plan = &layer,
                                    .resident = &steps_.of(layer.step),
                                    .numbers = pointNumbers(plan_, layer),
                                    .bricks = {}});
    }
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        if (!prepareVolume(layers_[i])) return false;
    }
    return true;
}

bool FrameRun::prepareVolume(LayerWork& work) {
    const ParticlesStyle& style = work.plan->style;
    if (!(style.volumeOpacity.maximum() > 0.0)) return true;
    const StepVolume* volume = steps_.volume(*work.resident, pacer_);
    if (volume == nullptr) return false;
    work.transfer = &transfers_.of(style);
    const auto visible = volume->visibleBricks(work.transfer->table);
    if (visible.empty()) return true;
    work.volume = volume;
    work.bricks = GlBuffer::of(std::span<const std::uint32_t>(visible));
    work.brickCount = static_cast<std::uint32_t>(visible.size());
    return pacer_.next();
}

bool FrameRun::drawBand(const Band& band, Picture& picture) {
    bindBand(band);
    markVolumes(band);
    if (!pacer_.next() || !markPoints()) return false;
    if (!drawCells(band, allocateCells(band))) return false;
    readBack(band, picture);
    return !pacer_.stopped();
}

void FrameRun::bindBand(const Band& band) {
    const Stage stage(*this, times_.allocate);
    std::array<std::uint32_t, 8> volumeSizes{};
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        volumeSizes[i] = layers_[i].volume == nullptr ? 0 : layers_[i].volume->size();
    }
    const FrameBlock block = frameBlock(plan_, format_, band.firstRow, band.rows, volumeSizes);
    buffers_.uniforms.grow(sizeof(block));
    buffers_.uniforms.write(0, sizeof(block), &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, buffers_.uniforms.get());
    const std::size_t pixelCount = std::size_t{band.tiles} * 64;
    const std::size_t maskBytes = pixelCount * layers_.size() * words_ * sizeof(std::uint32_t);
    const auto fresh = [](GlBuffer& buffer, Storage binding, std::size_t bytes, bool zero) {
        buffer.grow(bytes);
        if (zero) buffer.zero(bytes);
        buffer.bindStorage(binding);
    };
    fresh(buffers_.masks, masks, maskBytes, true);
    fresh(buffers_.volumeMasks, volumeMasks, maskBytes / 64, true);
    fresh(buffers_.counters, counters, sizeof(Counts), true);
    fresh(buffers_.tiles, tiles, 2 * band.tiles * sizeof(std::uint32_t), false);
    fresh(buffers_.offsets, offsets, pixelCount * layers_.size() * sizeof(std::uint32_t), false);
    fresh(buffers_.pixels, pixels, pixelCount * bytesPerPixel(format_), false);
    buffers_.pixels.fill(pixelCount * bytesPerPixel(format_), &block.blank.x,
                         format_ == PixelFormat::srgb8 ? 1 : 2);
}

void FrameRun::markVolumes(const Band&) {
    const Stage stage(*this, times_.volumeMark);
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const LayerWork& work = layers_[i];
        if (work.volume == nullptr) continue;
        const GLuint mark = program("volume_mark");
        glUseProgram(mark);
        glUniform1ui(0, static_cast<GLuint>(i));
        glUniform1ui(1, work.brickCount);
        glUniform1f(2, static_cast<float>(work.volume->brickEdge()));
        work.bricks.bindStorage(bricks);
        glDispatchCompute(groups(work.brickCount, 64), 1, 1);
    }
}

bool FrameRun::markPoints() {
    const Stage stage(*this, times_.pointsMark);
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        if (!dispatchPoints(i, pointsProgram("points_mark", i))) return false;
    }
    return true;
}

bool FrameRun::dispatchPoints(std::size_t layer, GLuint program) {
    LayerWork& work = layers_[layer];
    if (work.plan->pointsDrawn == 0 || !(work.numbers.tau > 0.0F)) return true;
    glProgramUniformMatrix4fv(program, 0, 1, GL_FALSE, glm::value_ptr(work.numbers.toScreen));
    glProgramUniform3uiv(program, 1, 1, glm::value_ptr(work.numbers.origin));
    glProgramUniform1ui(program, 2, static_cast<GLuint>(layer));
    if (work.numbers.discs) glProgramUniform1f(program, 3, work.numbers.radius);
    StepPoints& points = work.resident->points;
    points.select(*work.plan->step, work.plan->drawn);
    for (std::size_t i = 0; i < points.chunkCount(); ++i) {
        const auto chosen = points.blocks(i);
        if (chosen.empty()) continue;
        const PointChunk& chunk = steps_.chunk(*work.resident, i);
        buffers_.blocks.grow(chosen.size_bytes());
        buffers_.blocks.write(0, chosen.size_bytes(), chosen.data());
        buffers_.blocks.bindStorage(blocks);
        glBindTextureUnit(0, chunk.pointsTexture.get());
        glBindTextureUnit(1, chunk.endsTexture.get());
        glUseProgram(program);
        glDispatchCompute(static_cast<GLuint>(chosen.size()), 1, 1);
        if (!pacer_.next()) return false;
    }
    return true;
}

FrameRun::Counts FrameRun::allocateCells(const Band& band) {
    const Stage stage(*this, times_.allocate);
    barrier();
    glUseProgram(program("cells_allocate"));
    glDispatchCompute(groups(band.tiles, 64), 1, 1);
    barrier();
    Counts counts;
    buffers_.counters.read(0, sizeof(counts), &counts);
    times_.cells += counts.cells;
    return counts;
}

bool FrameRun::drawCells(const Band& band, const Counts& counts) {
    // A pixel belongs to the pass in which its first cell lies; its others may reach beyond by the margin.
    const std::uint64_t margin = layers_.size() * plan_.slabs;
    const std::uint64_t limit = std::min(options_.cellBytes, storageLimit()) / cellSize;
    const std::uint64_t capacity = std::min<std::uint64_t>(std::max(limit, 2 * margin) - margin, 1U << 30);
    buffers_.cells.grow((std::min<std::uint64_t>(counts.cells, capacity) + margin) * cellSize);
    buffers_.cells.bindStorage(cells);
    for (std::uint64_t first = 0; first <= counts.cells; first += capacity) {
        const Pass pass{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(capacity)};
        if (counts.cells > 0) {
            buffers_.cells.zero((std::min(counts.cells - first, capacity) + margin) * cellSize);
            if (!addPoints(pass)) return false;
        }
        if (!composite(0, counts.plainTiles, false, pass)) return false;
        if (!composite(band.tiles, counts.volumeTiles, true, pass)) return false;
        ++times_.passes;
    }
    return true;
}

bool FrameRun::addPoints(const Pass& pass) {
    const Stage stage(*this, times_.pointsAdd);
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const PointNumbers& numbers = layers_[i].numbers;
        const GLuint add = pointsProgram("points_add", i);
        glProgramUniform1f(add, 4, static_cast<float>(numbers.unit));
        if (numbers.discs) {
            glProgramUniform1f(add, 5, numbers.opacity);
            glProgramUniform1f(add, 6, 1.0F / numbers.tau);
        }
        glProgramUniform2ui(add, 7, pass.firstCell, pass.cells);
        if (!dispatchPoints(i, add)) return false;
    }
    barrier();
    return true;
}

bool FrameRun::composite(std::uint32_t firstTile, std::uint32_t tileCount, bool volume, const Pass& pass) {
    const Stage stage(*this, times_.composite);
    glUseProgram(compositeProgram(volume));
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const LayerWork& work = layers_[i];
        const auto unit = static_cast<GLuint>(i);
        glBindTextureUnit(unit, work.volume == nullptr ? 0 : work.volume->texture());
        glBindTextureUnit(transferUnits + unit, work.volume == nullptr ? 0 : work.transfer->texture.get());
    }
    glUniform2ui(1, pass.firstCell, pass.cells);
    barrier();
    for (std::uint32_t tile = 0; tile < tileCount; tile += tilesAtOnce) {
        glUniform1ui(0, firstTile + tile);
        glDispatchCompute(std::min(tilesAtOnce, tileCount - tile), 1, 1);
        if (!pacer_.next()) return false;
    }
    barrier();
    return true;
}

void FrameRun::readBack(const Band& band, Picture& picture) {
    const Stage stage(*this, times_.readBack);
    const std::size_t rowBytes = std::size_t{plan_.width} * bytesPerPixel(format_);
    const std::uint32_t first = band.firstRow * 8;
    const std::uint32_t last = std::min(first + band.rows * 8, plan_.height);
    buffers_.pixels.read(0, (last - first) * rowBytes, picture.pixels.data() + first * rowBytes);
}

GLuint FrameRun::program(std::string_view name) const {
    return shaders_.program(name, {{"LAYERS", static_cast<unsigned>(layers_.size())}, {"WORDS", words_}});
}

GLuint FrameRun::pointsProgram(std::string_view name, std::size_t layer) const {
    return shaders_.program(name, {{"LAYERS", static_cast<unsigned>(layers_.size())},
                                   {"WORDS", words_},
                                   {"DISCS", layers_[layer].numbers.discs ? 1U : 0U}});
}

GLuint FrameRun::compositeProgram(bool volume) const {
    return shaders_.program("composite", {{"LAYERS", static_cast<unsigned>(layers_.size())},
                                          {"WORDS", words_},
                                          {"VOLUME", volume ? 1U : 0U},
                                          {"EXACT", plan_.samplesPerCell >= 2.0 ? 1U : 0U}});
}

}  // namespace mote::render
