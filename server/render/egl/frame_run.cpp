// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_run.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

namespace mote::render {
namespace {

// Bindings of shader storage, as the shaders say.
enum Storage : GLuint { masks, offsets, cells, blocks, counters, volumeMasks, bricks, pixels, tiles };
// Texture units of the composite: volumes from 0, then
constexpr GLuint transferUnits = 8, maskUnit = 16, cellUnit = 17, volumeMaskUnit = 18;
constexpr std::uint32_t tilesAtOnce = 512;
constexpr std::size_t cellSize = 2 * sizeof(std::uint32_t);

void barrier() {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                    GL_TEXTURE_FETCH_BARRIER_BIT);
}

std::uint64_t storageLimit() {
    GLint64 limit = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    return static_cast<std::uint64_t>(std::max<GLint64>(limit, 1 << 24));
}

/// A view of the whole buffer, for quicker reading; made anew, since the buffer may be.
void viewAs(GLenum format, const GlBuffer& buffer, GlTexture& texture) {
    texture = bufferTexture(buffer, format);
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
    // Points of one colour with nothing between them look the same in any order.
    flat_ = layers_.size() == 1 && layers_[0].volume == nullptr;
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
    if (!(flat_ ? drawFlat(band) : drawSlabs(band))) return false;
    readBack(band, picture);
    return !pacer_.stopped();
}

bool FrameRun::drawFlat(const Band& band) {
    const std::size_t bytes = std::size_t{band.tiles} * 64 * sizeof(std::uint32_t);
    buffers_.cells.grow(bytes);
    buffers_.cells.zero(bytes);
    buffers_.cells.bindStorage(cells);
    if (!addPoints({})) return false;
    ++times_.passes;
    return composite(program("composite_flat"), 0, band.tiles);
}

bool FrameRun::drawSlabs(const Band& band) {
    markVolumes(band);
    return pacer_.next() && markPoints() && drawCells(band, allocateCells(band));
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
    const std::size_t pixelBytes = std::size_t{band.tiles} * 64 * bytesPerPixel(format_);
    buffers_.pixels.grow(pixelBytes);
    buffers_.pixels.fill(pixelBytes, &block.blank.x, format_ == PixelFormat::srgb8 ? 1 : 2);
    buffers_.pixels.bindStorage(pixels);
    if (flat_) return;
    const auto bind = [](GlBuffer& buffer, Storage binding, std::size_t bytes, bool zero) {
        buffer.grow(bytes);
        if (zero) buffer.zero(bytes);
        buffer.bindStorage(binding);
    };
    const std::size_t tileWords = layers_.size() * words_ * sizeof(std::uint32_t);
    bind(buffers_.masks, masks, std::size_t{band.tiles} * 64 * 2 * tileWords, true);
    bind(buffers_.volumeMasks, volumeMasks, band.tiles * tileWords, true);
    viewAs(GL_RG32UI, buffers_.masks, buffers_.masksTexture);
    viewAs(GL_R32UI, buffers_.volumeMasks, buffers_.volumeMasksTexture);
    bind(buffers_.counters, counters, sizeof(Counts), true);
    bind(buffers_.offsets, offsets, std::size_t{band.tiles} * 64 * sizeof(std::uint32_t), false);
    bind(buffers_.tiles, tiles, std::size_t{band.tiles} * 3 * sizeof(std::uint32_t), false);
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
        if (!dispatchPoints("points_mark", i, {})) return false;
    }
    return true;
}

bool FrameRun::dispatchPoints(std::string_view name, std::size_t layer, const Pass& pass) {
    const LayerWork& work = layers_[layer];
    if (work.plan->pointsDrawn == 0 || !(work.numbers.tau > 0.0F)) return true;
    StepPoints& points = work.resident->points;
    points.select(*work.plan->step, work.plan->drawn);
    for (std::size_t i = 0; i < points.chunkCount(); ++i) {
        const ChunkSelection& selection = points.selection(i);
        if (selection.empty()) continue;
        const PointChunk& chunk = steps_.chunk(*work.resident, i);
        glBindTextureUnit(0, chunk.pointsTexture.get());
        glBindTextureUnit(1, chunk.selectedTexture.get());
        const GLuint program = pointsProgram(name, layer, selection.listed);
        setPointUniforms(program, layer, pass);
        glUseProgram(program);
        if (selection.listed) {
            const auto count = static_cast<std::uint32_t>(selection.numbers.size());
            glUniform1ui(glGetUniformLocation(program, "listed"), count);
            glDispatchCompute(groups(count, StepPoints::blockPoints), 1, 1);
        } else {
            const std::size_t bytes = selection.blocks.size() * sizeof(std::uint32_t);
            buffers_.blocks.grow(bytes);
            buffers_.blocks.write(0, bytes, selection.blocks.data());
            buffers_.blocks.bindStorage(blocks);
            glDispatchCompute(static_cast<GLuint>(selection.blocks.size()), 1, 1);
        }
        if (!pacer_.next()) return false;
    }
    return true;
}

void FrameRun::setPointUniforms(GLuint program, std::size_t layer, const Pass& pass) const {
    const PointNumbers& numbers = layers_[layer].numbers;
    // Not every variant has every uniform; GL ignores what has no place (-1).
    const auto place = [program](const char* uniform) { return glGetUniformLocation(program, uniform); };
    glProgramUniformMatrix4fv(program, place("toScreen"), 1, GL_FALSE, glm::value_ptr(numbers.toScreen));
    glProgramUniform3uiv(program, place("origin"), 1, glm::value_ptr(numbers.origin));
    glProgramUniform1ui(program, place("layer"), static_cast<GLuint>(layer));
    glProgramUniform1f(program, place("radius"), numbers.radius);
    glProgramUniform1f(program, place("unit"), static_cast<float>(numbers.unit));
    glProgramUniform1f(program, place("opacity"), numbers.opacity);
    glProgramUniform1f(program, place("inverseTau"), 1.0F / numbers.tau);
    glProgramUniform2ui(program, place("pass"), pass.firstCell, pass.cells);
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
    viewAs(GL_RG32UI, buffers_.cells, buffers_.cellsTexture);
    for (std::uint64_t first = 0; first <= counts.cells; first += capacity) {
        const auto present = static_cast<std::uint32_t>(std::min(counts.cells - first, capacity) + margin);
        const auto firstCell = static_cast<std::uint32_t>(first);
        if (counts.cells > 0) {
            buffers_.cells.zero(present * cellSize);
            if (!addPoints({firstCell, present})) return false;
        }
        const Pass pass{firstCell, static_cast<std::uint32_t>(capacity)};
        if (!composite(compositeProgram(true, false, pass), 0, counts.tiles[0])) return false;
        if (!composite(compositeProgram(false, true, pass), band.tiles, counts.tiles[1])) return false;
        if (!composite(compositeProgram(true, true, pass), 2 * band.tiles, counts.tiles[2])) return false;
        ++times_.passes;
    }
    return true;
}

bool FrameRun::addPoints(const Pass& pass) {
    const Stage stage(*this, times_.pointsAdd);
    if (!flat_) glBindTextureUnit(2, buffers_.masksTexture.get());
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        if (!dispatchPoints("points_add", i, pass)) return false;
    }
    barrier();
    return true;
}

bool FrameRun::composite(GLuint program, std::uint32_t firstTile, std::uint32_t tileCount) {
    const Stage stage(*this, times_.composite);
    glUseProgram(program);
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const LayerWork& work = layers_[i];
        const auto unit = static_cast<GLuint>(i);
        glBindTextureUnit(unit, work.volume == nullptr ? 0 : work.volume->texture());
        glBindTextureUnit(transferUnits + unit, work.volume == nullptr ? 0 : work.transfer->texture.get());
    }
    glBindTextureUnit(maskUnit, buffers_.masksTexture.get());
    glBindTextureUnit(cellUnit, buffers_.cellsTexture.get());
    glBindTextureUnit(volumeMaskUnit, buffers_.volumeMasksTexture.get());
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

GLuint FrameRun::pointsProgram(std::string_view name, std::size_t layer, bool listed) const {
    return shaders_.program(name, {{"LAYERS", static_cast<unsigned>(layers_.size())},
                                   {"WORDS", words_},
                                   {"DISCS", layers_[layer].numbers.discs ? 1U : 0U},
                                   {"FLAT", flat_ ? 1U : 0U},
                                   {"LISTED", listed ? 1U : 0U}});
}

GLuint FrameRun::compositeProgram(bool points, bool volume, const Pass& pass) const {
    const GLuint program = shaders_.program("composite", {{"LAYERS", static_cast<unsigned>(layers_.size())},
                                                          {"WORDS", words_},
                                                          {"POINTS", points ? 1U : 0U},
                                                          {"VOLUME", volume ? 1U : 0U},
                                                          {"EXACT", plan_.samplesPerCell >= 2.0 ? 1U : 0U}});
    glProgramUniform2ui(program, 1, pass.firstCell, pass.cells);
    return program;
}

}  // namespace mote::render
