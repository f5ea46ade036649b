// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_texture.h"
#include "server/render/ink/segments_graph.h"
namespace mote::render {
Segments textureSegments(const Modalities& modalities, std::size_t, const std::stop_token& stop) {
    return graphSegments(modalities, stop);
}
}  // namespace mote::render
