// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/step_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "server/render/device.h"

namespace mote::render {
namespace {

/// A texel as shaders/grid.glsl reads it: five neighbours along x, the last of which is the next one's first.
using Texel = std::array<std::uint32_t, 4>;

constexpr std::size_t piece = std::size_t{1} << 18;  // texels that are packed at once, about

/// Rows of samples along x, which lie side by side.
struct Rows {
    const std::uint16_t* codes;
    const std::uint8_t* normals;
    std::size_t samples, count;  ///< of a row; rows

    std::size_t texels() const { return std::max<std::size_t>((samples + 2) / 4, 1); }  ///< of a row
};

void checkSize(const glm::uvec3& grid, std::size_t texels) {
    const std::uint32_t longest = std::max({grid.x, grid.y, grid.z});
    // volume_mark.comp numbers bricks in ten bits.
    if (longest > 1024 * StepGrid::brickEdge)
        throw DeviceError(fmt::format("the device draws hybrid volumes of {} samples along an edge at most",
                                      1024 * StepGrid::brickEdge));
    GLint held = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &held);
    // Some drivers count a texel's place in bytes, in 31 bits.
    const std::size_t most = std::min<std::size_t>(std::max(held, 0), (1U << 31) / sizeof(Texel) - 1);
    if (texels > most)
        throw DeviceError(
            fmt::format("this hybrid volume takes {} MiB of the device's memory in one piece, "
                        "and it gives {}; a greater threshold leaves fewer corrections",
                        texels * sizeof(Texel) >> 20, most * sizeof(Texel) >> 20));
}

/// The texel of the samples from these on; those beyond the row are read with a weight of 0.
Texel packed(const std::uint16_t* code, const std::uint8_t* normal) {
    const auto word = [](std::uint32_t low, std::uint32_t high) { return low | high << 16; };
    const auto normals = [&](int i) { return normal[i] | std::uint32_t{normal[i + 1]} << 8; };
    return {word(code[0], code[1]), word(code[2], code[3]), word(code[4], normals(0)),
            word(normals(2), normal[4])};
}

/// Packs and writes rows from the texel `begin` on. Four samples beyond the last can be read. False where the
/// frame is given up.
bool write(GlBuffer& buffer, std::size_t begin, const Rows& rows, const Pacer& pacer) {
    const std::size_t across = rows.texels(), atOnce = std::max<std::size_t>(piece / across, 1);
    std::vector<Texel> texels;
    for (std::size_t first = 0; first < rows.count; first += atOnce) {
        if (pacer.stopped()) return false;
        texels.clear();
        for (std::size_t row = first; row < std::min(rows.count, first + atOnce); ++row) {
            for (std::size_t i = 0; i < across; ++i) {
                const std::size_t sample = row * rows.samples + 4 * i;
                texels.push_back(packed(rows.codes + sample, rows.normals + sample));
            }
        }
        buffer.write((begin + first * across) * sizeof(Texel), texels.size() * sizeof(Texel), texels.data());
    }
    return true;
}

}  // namespace

std::optional<StepGrid> StepGrid::load(const GridField& step, bool corrected, const Pacer& pacer) {
    const GridBricks* bricks = corrected ? step.bricks.get() : nullptr;
    StepGrid made(step, bricks);
    if (!made.upload(step, bricks, pacer)) return std::nullopt;
    return made;
}

StepGrid::StepGrid(const GridField& step, const GridBricks* bricks)
    : grid_(bricks == nullptr ? step.coarse.size : bricks->size) {}

bool StepGrid::upload(const GridField& step, const GridBricks* bricks, const Pacer& pacer) {
    const glm::uvec3& size = step.coarse.size;
    const Rows low{step.coarse.values.data(), step.coarse.normals.data(), size.x,
                   std::size_t{size.y} * size.z};
    const std::size_t lowTexels = low.texels() * low.count;
    Rows fine{nullptr, nullptr, GridBricks::samples, 0};
    if (bricks != nullptr) {
        fine.codes = bricks->values.data();
        fine.normals = bricks->normals.data();
        fine.count = bricks->corrected() * GridBricks::samples * GridBricks::samples;
    }
    // Where a grid ends, neighbours beyond are read with a weight of 0.
    const std::size_t beyond = low.texels() * (size.y + 1) + 1;
    const std::size_t all = lowTexels + fine.texels() * fine.count + beyond;
    checkSize(grid_, all);
    samples_ = GlBuffer(all * sizeof(Texel));
    samplesTexture_ = bufferTexture(samples_, GL_RGBA32UI);
    return write(samples_, 0, low, pacer) && write(samples_, lowTexels, fine, pacer);
}

}  // namespace mote::render
