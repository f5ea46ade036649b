// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/transfer_textures.h"

#include <algorithm>

namespace mote::render {

const TransferTexture& TransferTextures::of(const ParticlesStyle& style) {
    const auto found = std::find_if(textures_.begin(), textures_.end(), [&](const TransferTexture& texture) {
        return texture.volumeOpacity == style.volumeOpacity && texture.colorMap == style.colorMap;
    });
    if (found != textures_.end()) {
        textures_.splice(textures_.begin(), textures_, found);
        return textures_.front();
    }
    TransferTexture made{style.volumeOpacity, style.colorMap, TransferTable(style), {}, {}};
    made.buffer = GlBuffer::of(std::span<const glm::vec4>(made.table.integrals()));
    made.texture = bufferTexture(made.buffer, GL_RGBA32F);
    textures_.push_front(std::move(made));
    if (textures_.size() > kept) textures_.pop_back();
    return textures_.front();
}

}  // namespace mote::render
