// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "server/render/egl/frame_gl.h"
#include "server/render/egl/frame_run.h"

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

// Dots: what the shaders read of them, and which touch each tile, front to back.

void FrameRun::prepareDots() {
    dots_ = screenDots(plan_);
    std::vector<glm::vec4> texels;
    texels.reserve(2 * dots_.size());
    for (const auto& dot : dots_) {
        texels.emplace_back(dot.x, dot.y, dot.ink.reach, dot.place);
        texels.emplace_back(dot.color, dot.ink.most);
    }
    if (dots_.empty()) return;
    buffers_.dots = GlBuffer::of(std::span<const glm::vec4>(texels));
    buffers_.dotsTexture = bufferTexture(buffers_.dots, GL_RGBA32F);
}

/// First where the list of each tile begins, and where the last one ends; then the lists.
void FrameRun::bindDots(const Band& band) {
    if (dots_.empty()) return;
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
    for (const auto& dot : dots_) forTiles(dot, [&](std::size_t tile) { ++words[tile + 1]; });
    words[0] = band.tiles + 1;
    for (std::size_t tile = 0; tile < band.tiles; ++tile) words[tile + 1] += words[tile];
    std::vector<std::uint32_t> next(words.begin(), words.end() - 1);
    words.resize(words.back());
    for (std::uint32_t i = 0; i < dots_.size(); ++i)
        forTiles(dots_[i], [&](std::size_t tile) { words[next[tile]++] = i; });
    buffers_.dotLists = GlBuffer::of(std::span<const std::uint32_t>(words));
    buffers_.dotListsTexture = bufferTexture(buffers_.dotLists, GL_R32UI);
}

}  // namespace mote::render
