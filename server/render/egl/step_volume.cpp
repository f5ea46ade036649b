// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/step_volume.h"

#include <algorithm>

#include "storage/storage_error.h"

namespace mote::render {
namespace {

/// Each brick's own cells and one more on every side, since interpolation looks that far.
struct Reach {
    std::uint32_t begin, end;
};

Reach reach(std::uint32_t brick, std::uint32_t brickCells, std::uint32_t size) {
    const std::uint32_t begin = brick * brickCells;
    return {begin == 0 ? 0 : begin - 1, std::min(size, begin + brickCells + 1)};
}

}  // namespace

GlTexture volumeTexture(std::uint32_t size, const float* t) {
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_3D, 1, &name);
    GlTexture texture(name);
    const auto side = static_cast<GLsizei>(size);
    glTextureStorage3D(name, 1, GL_R32F, side, side, side);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
        glTextureParameteri(name, axis, GL_CLAMP_TO_EDGE);
    }
    glTextureSubImage3D(name, 0, 0, 0, 0, side, side, side, GL_RED, GL_FLOAT, t);
    return texture;
}

std::optional<StepVolume> StepVolume::load(const storage::ParticleStep& step, const Pacer& pacer) {
    const std::uint32_t size = step.volumeSize();
    const auto densities = step.volume();
    if (size == 0 || size > 1024 || densities.size() != std::size_t{size} * size * size) {
        throw storage::StorageError(
            Error{ErrorCode::corrupt, "/volume/density", "the volume's size is not its shape"});
    }
    const LogDensity scale = step.logDensity();
    std::vector<float> t(densities.size());
    const std::size_t slice = std::size_t{size} * size;
    for (std::size_t begin = 0; begin < t.size(); begin += slice) {
        if (pacer.stopped()) return std::nullopt;
        for (std::size_t i = begin; i < begin + slice; ++i)
            t[i] = static_cast<float>(scale.ofCell(densities[i]));
    }
    return StepVolume(size, t);
}

StepVolume::StepVolume(std::uint32_t size, const std::vector<float>& t)
    : texture_(volumeTexture(size, t.data())),
      size_(size),
      brickCells_(std::max(2U, (size + 31) / 32)),
      bricks_((size + brickCells_ - 1) / brickCells_) {
    checkGl("a volume");
    ranges_.reserve(std::size_t{bricks_} * bricks_ * bricks_);
    for (std::uint32_t bz = 0; bz < bricks_; ++bz) {
        for (std::uint32_t by = 0; by < bricks_; ++by) {
            for (std::uint32_t bx = 0; bx < bricks_; ++bx) {
                const auto x = reach(bx, brickCells_, size), y = reach(by, brickCells_, size),
                           z = reach(bz, brickCells_, size);
                Range range{1.0F, -1.0F};
                for (std::size_t k = z.begin; k < z.end; ++k) {
                    for (std::size_t j = y.begin; j < y.end; ++j) {
                        const float* row = t.data() + (k * size + j) * size;
                        const auto [low, high] = std::minmax_element(row + x.begin, row + x.end);
                        range = {std::min(range.low, *low), std::max(range.high, *high)};
                    }
                }
                ranges_.push_back(range);
            }
        }
    }
}

std::vector<std::uint32_t> StepVolume::visibleBricks(const TransferTable& table) const {
    std::vector<std::uint32_t> visible;
    std::size_t i = 0;
    for (std::uint32_t z = 0; z < bricks_; ++z) {
        for (std::uint32_t y = 0; y < bricks_; ++y) {
            for (std::uint32_t x = 0; x < bricks_; ++x, ++i) {
                if (table.visible(ranges_[i].low, ranges_[i].high)) visible.push_back(x | y << 10 | z << 20);
            }
        }
    }
    return visible;
}

}  // namespace mote::render
