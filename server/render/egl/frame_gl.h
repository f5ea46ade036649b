// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the parts of FrameRun share: where the shaders expect their buffers, and the limits of GL. Used while
// the device's context is current.
#pragma once

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdint>

namespace mote::render {

/// Bindings of shader storage; GL guarantees no more than eight. Blocks of points, bricks of volume and rays
/// by section are bound only for the dispatch that reads them, and share one.
enum Storage : GLuint {
    masks,
    offsets,
    cells,
    blocks,
    counters,
    volumeMasks,
    tiles,
    pixels,
    bricks = blocks,
    sections = blocks
};

/// Texture units of points' programs and of cells_allocate.
enum PointUnit : GLuint { pointUnit, selectedUnit, slabBitsUnit, allocateDotsUnit };

/// Texture units of composite.comp: eight volumes or hybrid volumes' samples from 0, then these.
enum CompositeUnit : GLuint {
    tableUnit = 8,
    maskUnit,
    cellUnit,
    volumeMaskUnit,
    dotUnit,
    dotListUnit,
    gridBrickUnit
};

/// What shaders wrote before is seen by whatever reads it after.
inline void barrier() {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                    GL_TEXTURE_FETCH_BARRIER_BIT);
}

/// The most bytes, at most `wanted`, of a buffer of pairs of words that shaders write and read as texels.
inline std::uint64_t pairLimit(std::uint64_t wanted) {
    GLint64 block = 0;
    GLint64 texels = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    glGetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    // GL guarantees at least this much of each.
    const auto most = std::min(std::max<GLint64>(block, 1 << 27), 8 * std::max<GLint64>(texels, 1 << 16));
    return std::min(wanted, static_cast<std::uint64_t>(most));
}

/// Work groups of `size` for so many invocations.
inline std::uint32_t groups(std::uint32_t invocations, std::uint32_t size) {
    return (invocations + size - 1) / size;
}

}  // namespace mote::render
