// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_run.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <glm/packing.hpp>

#include "server/render/plan/screen_map.h"

namespace mote::render {
namespace {

/// Tiles [begin, end) of a row or column that an interval of pixels meets.
struct TileRange {
    std::int64_t begin, end;

    TileRange(float centre, float reach, std::int64_t first, std::int64_t last) {
        const auto tile = [&](float at) {
            const auto most = static_cast<double>(last);
            return static_cast<std::int64_t>(std::clamp(std::floor(static_cast<double>(at) / 8.0),
                                                        static_cast<double>(first) - 1.0, most));
        };
        begin = std::max(tile(centre - reach), first);
        end = std::min(tile(centre + reach) + 1, last);
    }
};

}  // namespace

FrameRun::FrameRun(const FramePlan& plan, const FrameColors& colors, PixelFormat format,
                   const EglOptions& options, ShaderLibrary& shaders, ResidentSteps& steps,
                   ResidentGrids& residentGrids, DensityTables& tables, FrameBuffers& buffers,
                   std::stop_token stop)
    : plan_(plan),
      frameColors_(colors),
      format_(format),
      options_(options),
      shaders_(shaders),
      steps_(steps),
      residentGrids_(residentGrids),
      tables_(tables),
      buffers_(buffers),
      stop_(std::move(stop)),
      pacer_({}),
      words_(groups(std::max(plan.slabs, 1U), 32)),
      tilesAcross_(groups(plan.width, 8)),
      tilesDown_(groups(plan.height, 8)) {}

Picture newPicture(const FramePlan& plan, PixelFormat format) {
    Picture picture{.width = plan.width, .height = plan.height, .format = format, .pixels = {}};
    picture.pixels.resize(std::size_t{plan.width} * plan.height * bytesPerPixel(format));
    for (const auto& points : plan.points) picture.pointsDrawn += points.pointsDrawn;
    return picture;
}

bool FrameRun::draw(Picture& picture, std::uint32_t& next, bool patient) {
    if (!patient) pacer_.heed(stop_);
    if (!prepare()) return false;
    const std::uint32_t rows = rowsOfABand();
    while (next < tilesDown_) {
        const std::uint32_t count = std::min(rows, tilesDown_ - next);
        if (!drawBand({next, count, count * tilesAcross_}, picture)) return false;
        ++times_.bands;
        next += count;
        pacer_.heed(stop_);
        if (next < tilesDown_ && pacer_.stopped()) return false;
    }
    checkGl("a picture");
    return true;
}

std::uint32_t FrameRun::rowsOfABand() const {
    // A pixel: its sum of weights, or for each layer pairs of slab bits and first cell.
    const std::uint64_t pixelBytes = (flat_ ? 1 : 2 * layerCount() * words_) * sizeof(std::uint32_t);
    const std::uint64_t rowBytes = std::uint64_t{tilesAcross_} * 64 * pixelBytes;
    std::uint64_t rows = std::max<std::uint64_t>(pairLimit(options_.maskBytes) / rowBytes, 1);
    // A pixel's colour is a pair of words, too.
    const std::uint64_t colorBytes =
        std::uint64_t{plan_.width} * 8 * 8 * std::max<std::size_t>(colors_.size(), 1);
    rows = std::clamp<std::uint64_t>(pairLimit(options_.maskBytes) / colorBytes, 1, rows);
    // What has no points is not made dearer by more bands, between which others' pictures may be drawn; rays
    // that look for surfaces take longer.
    const std::uint64_t mostPixels = std::uint64_t{1} << (plan_.surfaces.empty() ? 21 : 18);
    if (!anyPoints_)
        rows = std::clamp<std::uint64_t>(mostPixels / (std::uint64_t{tilesAcross_} * 64), 1, rows);
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(rows, tilesDown_));
}

bool FrameRun::prepare() {
    const Stage stage(*this, times_.prepare);
    for (const auto& slot : layerSlots(plan_)) {
        const auto& step = slot.points != nullptr ? slot.points->step : slot.densities->density()->step;
        LayerWork work{.slot = slot,
                       .resident = &steps_.of(step),
                       .bends = BendBlock(slabBends(
                           plan_, slot.points != nullptr ? slot.points->boxToEye : slot.boxToEye())),
                       .bricks = {}};
        if (slot.points != nullptr) work.numbers = pointNumbers(plan_, *slot.points);
        layers_.push_back(std::move(work));
    }
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        if (!prepareVolume(layers_[i])) return false;
    }
    for (const auto& colors : frameColors_) {
        if (colors != nullptr) colors_.push_back(colors.get());
    }
    if (!prepareGrids()) return false;
    // Points of one colour with nothing between them look the same in any order.
    flat_ = layers_.size() == 1 && layers_[0].volume == nullptr && grids_.empty() && !plan_.anyDots() &&
            (layers_[0].slot.points == nullptr || layers_[0].slot.points->alike(plan_.camera.perspective()));
    prepareDots();
    if (!flat_) gatherTables();
    anyPoints_ =
        std::any_of(layers_.begin(), layers_.end(), [](const LayerWork& work) { return work.drawsPoints(); });
    return true;
}

bool FrameRun::prepareVolume(LayerWork& work) {
    if (work.slot.densities == nullptr) return true;
    const GridVolume& volume = steps_.volume(work.slot.densities->density()->grid);
    work.table = &tables_.of(colorsOf(work.slot.densities->transfer));
    const auto& visible = volume.visibleBricks();
    if (visible.empty()) return true;
    work.volume = &volume;
    work.volumeBends.emplace(slabBends(plan_, work.slot.boxToEye()));
    work.bricks = GlBuffer::of(std::span<const std::uint32_t>(visible));
    work.brickCount = static_cast<std::uint32_t>(visible.size());
    return pacer_.next();
}

/// One table after the other, so that a shader needs one texture for all.
void FrameRun::gatherTables() {
    std::vector<TableEntry> all;
    const auto add = [&](const std::vector<TableEntry>& table) {
        all.insert(all.end(), table.begin(), table.end());
    };
    const std::vector<TableEntry> none(TransferTable::cells + 2);
    for (const auto& work : layers_) add(work.volume == nullptr ? none : work.table->entries);
    for (const auto& work : grids_) add(work.bricks->table);
    if (all.empty()) add(none);
    buffers_.tables = GlBuffer::of(std::span<const TableEntry>(all));
    buffers_.tablesTexture = bufferTexture(buffers_.tables, GL_RGBA32UI);
}

bool FrameRun::drawBand(const Band& band, Picture& picture) {
    bindBand(band);
    if (!(flat_ ? drawFlat(band) : drawSlabs(band))) return false;
    readBack(band, picture);
    return !pacer_.stopped();
}

bool FrameRun::drawSlabs(const Band& band) {
    markVolumes();
    return pacer_.next() && markPoints() && drawCells(band, allocateCells(band));
}

void FrameRun::bindBand(const Band& band) {
    const Stage stage(*this, times_.allocate);
    FrameBlock block = frameBlock(plan_, format_, band.firstRow, band.rows);
    block.counts = glm::uvec4(layerCount(), words_, 0, 0);
    // Slots of points come first, in their order.
    for (std::size_t i = 0, list = 0; i < frameColors_.size(); ++i)
        block.layers[i].scale.z = frameColors_[i] == nullptr ? 0.0F : static_cast<float>(++list);
    buffers_.uniforms.grow(sizeof(block));
    buffers_.uniforms.write(0, sizeof(block), &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, buffers_.uniforms.get());
    const std::size_t pixelBytes = std::size_t{band.tiles} * 64 * bytesPerPixel(format_);
    buffers_.pixels.grow(pixelBytes);
    buffers_.pixels.fill(pixelBytes, &block.blank.x, format_ == PixelFormat::srgb8 ? 1 : 2);
    buffers_.pixels.bindStorage(pixels);
    bindColors(band);
    if (flat_) return;
    bindDots(band);
    const auto bind = [](GlBuffer& buffer, Storage binding, std::size_t bytes, bool zero) {
        buffer.grow(bytes);
        if (zero) buffer.zero(bytes);
        buffer.bindStorage(binding);
    };
    const std::size_t tileWords = layerCount() * words_ * sizeof(std::uint32_t);
    bind(buffers_.masks, masks, std::size_t{band.tiles} * 64 * 2 * tileWords, anyPoints_);
    bind(buffers_.volumeMasks, volumeMasks, band.tiles * tileWords, true);
    buffers_.masksTexture = bufferTexture(buffers_.masks, GL_RG32UI);
    buffers_.volumeMasksTexture = bufferTexture(buffers_.volumeMasks, GL_R32UI);
    bind(buffers_.counters, counters, sizeof(Counts), true);
    bind(buffers_.offsets, offsets, std::size_t{band.tiles} * 64 * sizeof(std::uint32_t), false);
    bind(buffers_.tiles, tiles, std::size_t{band.tiles} * 3 * sizeof(std::uint32_t), false);
    if (plan_.sections.size() == 1) return;
    const auto rays = sectionRays(plan_);
    buffers_.sections.grow(rays.size() * sizeof(glm::vec4));
    buffers_.sections.write(0, rays.size() * sizeof(glm::vec4), rays.data());
}

void FrameRun::markVolumes() {
    const Stage stage(*this, times_.volumeMark);
    const GLuint mark = shaders_.program("volume_mark", {});
    glUseProgram(mark);
    const auto dispatch = [mark](std::size_t layer, const GlBuffer& visible, std::uint32_t count,
                                 const glm::vec3& edge, const glm::vec3& shift, const BendBlock& bends) {
        if (count == 0) return;
        bends.set(mark);
        glUniform1ui(0, static_cast<GLuint>(layer));
        glUniform1ui(1, count);
        glUniform3fv(2, 1, &edge.x);
        glUniform3fv(3, 1, &shift.x);
        visible.bindStorage(bricks);
        glDispatchCompute(groups(count, 64), 1, 1);
    };
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const LayerWork& work = layers_[i];
        if (work.volume == nullptr) continue;
        dispatch(i, work.bricks, work.brickCount, work.volume->brickEdge(), glm::vec3(0.0F),
                 *work.volumeBends);
    }
    for (std::size_t i = 0; i < grids_.size(); ++i) {
        const GridWork& work = grids_[i];
        const glm::vec3 grid(work.resident->samples.grid());
        // Samples lie at the centres of the grid's cells, bricks between samples.
        dispatch(layers_.size() + i, work.visible, work.visibleCount, float{StepGrid::brickEdge} / grid,
                 0.5F / grid, BendBlock(slabBends(plan_, work.plan->boxToEye)));
    }
}

void FrameRun::readBack(const Band& band, Picture& picture) {
    const Stage stage(*this, times_.readBack);
    const std::size_t rowBytes = std::size_t{plan_.width} * bytesPerPixel(format_);
    const std::uint32_t first = band.firstRow * 8;
    const std::uint32_t last = std::min(first + band.rows * 8, plan_.height);
    buffers_.pixels.read(0, (last - first) * rowBytes, picture.pixels.data() + first * rowBytes);
}

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
        const StepGrid& samples = work.resident->samples;
        blocks[i] = gridBlock(plan_, *work.plan, *work.samples, samples.grid(), work.firstBrick,
                              samples.firstSlope());
    }
    buffers_.gridBricks = GlBuffer::of(std::span<const std::uint32_t>(words));
    buffers_.gridBricksTexture = bufferTexture(buffers_.gridBricks, GL_R32UI);
    buffers_.grids = GlBuffer(sizeof(blocks), blocks.data());
}

// Dots: what the shaders read of them, and which touch each tile, front to back.

namespace {

PlacedDots sortedDots(const PlacedDots& dots) {
    PlacedDots sorted;
    for (const auto index : frontToBack(dots)) {
        sorted.dots.push_back(dots.dots[index]);
        sorted.depths.push_back(dots.depths[index]);
    }
    return sorted;
}

}  // namespace

void FrameRun::prepareDots() {
    placeDots(plan_, dots_);
    makers_ = makersOf(plan_);
    anyDots_ = !dots_.dots.empty() || !makers_.empty();
    if (!makers_.empty() || !anyDots_) return;
    dots_ = sortedDots(dots_);
    writeDots(dots_.dots);
}

void FrameRun::writeDots(const std::vector<ScreenDot>& dots) {
    std::vector<glm::vec4> texels;
    texels.reserve(2 * dots.size() + 1);
    for (const auto& dot : dots) {
        texels.emplace_back(dot.x, dot.y, dot.ink.reach, dot.place);
        texels.emplace_back(dot.color, dot.ink.most);
    }
    if (texels.empty()) texels.emplace_back(0.0F);  // there are no empty buffers
    buffers_.dots = GlBuffer::of(std::span<const glm::vec4>(texels));
    buffers_.dotsTexture = bufferTexture(buffers_.dots, GL_RGBA32F);
}

/// The colours of the band's pixels, one list after the other.
void FrameRun::bindColors(const Band& band) {
    if (colors_.empty()) return;
    const std::uint32_t first = band.firstRow * 8, end = std::min(first + band.rows * 8, plan_.height);
    std::vector<std::uint64_t> texels;
    texels.reserve(colors_.size() * plan_.width * (end - first));
    for (const auto* const colors : colors_) {
        std::vector<std::uint64_t> shades;
        for (const auto& color : colors->colors())
            shades.push_back(glm::packHalf4x16(glm::vec4(color, 1.0F)));
        const auto places =
            std::span(colors->places())
                .subspan(std::size_t{first} * plan_.width, std::size_t{end - first} * plan_.width);
        for (const auto place : places) texels.push_back(shades[place]);
    }
    buffers_.colors = GlBuffer::of(std::span<const std::uint64_t>(texels));
    buffers_.colorsTexture = bufferTexture(buffers_.colors, GL_RGBA16F);
}

/// The dots of a band, with what surfaces and strokes are there, front to back.
PlacedDots FrameRun::madeDots(const Band& band) const {
    const std::uint32_t first = band.firstRow * 8, end = std::min(first + band.rows * 8, plan_.height);
    const auto top = static_cast<float>(first), bottom = static_cast<float>(end);
    PlacedDots dots;
    for (std::size_t i = 0; i < dots_.dots.size(); ++i) {
        const auto& dot = dots_.dots[i];
        if (dot.y + dot.ink.reach < top || dot.y - dot.ink.reach > bottom) continue;
        dots.dots.push_back(dot);
        dots.depths.push_back(dots_.depths[i]);
    }
    constexpr std::uint32_t edge = 32;  // a task's part of the band
    const std::uint32_t across = (plan_.width + edge - 1) / edge, down = (end - first + edge - 1) / edge;
    std::vector<PlacedDots> parts(std::size_t{across} * down);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
        const auto left = static_cast<std::uint32_t>(i % across) * edge,
                   above = first + static_cast<std::uint32_t>(i / across) * edge;
        placeMade(makers_, {left, above, std::min(left + edge, plan_.width), std::min(above + edge, end)},
                  plan_.sections, parts[i]);
    });
    for (const auto& part : parts) {
        dots.dots.insert(dots.dots.end(), part.dots.begin(), part.dots.end());
        dots.depths.insert(dots.depths.end(), part.depths.begin(), part.depths.end());
    }
    return sortedDots(dots);
}

/// First where the list of each tile begins, and where the last one ends; then the lists.
void FrameRun::bindDots(const Band& band) {
    PlacedDots made;
    if (!makers_.empty()) {
        made = madeDots(band);
        writeDots(made.dots);
    }
    if (!anyDots_) return;
    const auto& dots = makers_.empty() ? dots_.dots : made.dots;
    const std::int64_t across = tilesAcross_, top = band.firstRow, bottom = top + band.rows;
    const auto forTiles = [&](const ScreenDot& dot, auto visit) {
        const TileRange rows(dot.y, dot.ink.reach, top, bottom);
        const TileRange columns(dot.x, dot.ink.reach, 0, across);
        for (auto row = rows.begin; row < rows.end; ++row) {
            for (auto column = columns.begin; column < columns.end; ++column)
                visit(static_cast<std::size_t>((row - top) * across + column));
        }
    };
    std::vector<std::uint32_t> words(band.tiles + 1, 0);
    for (const auto& dot : dots) forTiles(dot, [&](std::size_t tile) { ++words[tile + 1]; });
    words[0] = band.tiles + 1;
    for (std::size_t tile = 0; tile < band.tiles; ++tile) words[tile + 1] += words[tile];
    std::vector<std::uint32_t> next(words.begin(), words.end() - 1);
    words.resize(words.back());
    for (std::uint32_t i = 0; i < dots.size(); ++i)
        forTiles(dots[i], [&](std::size_t tile) { words[next[tile]++] = i; });
    buffers_.dotLists = GlBuffer::of(std::span<const std::uint32_t>(words));
    buffers_.dotListsTexture = bufferTexture(buffers_.dotLists, GL_R32UI);
}

}  // namespace mote::render
