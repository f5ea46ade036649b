// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments.h"

#include "server/render/ink/segments_cut.h"
#include "server/render/ink/segments_graph.h"
#include "server/render/ink/segments_growing.h"
#include "server/render/ink/segments_texture.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

Segments partedBy(const Modalities& modalities, const SegmentOptions& options, const std::stop_token& stop) {
    switch (options.method) {
        case Segmentation::graph:
            return graphSegments(modalities, options.leastPixels, stop);
        case Segmentation::cut:
            return cutSegments(modalities, options.leastPixels, stop);
        case Segmentation::texture:
            return textureSegments(modalities, options.leastPixels, stop);
        default:
            return grownSegments(modalities, {}, options.leastPixels, stop);
    }
}

}  // namespace

Segments segmentsOf(const Modalities& modalities, const SegmentOptions& options,
                    const std::stop_token& stop) {
    auto made = partedBy(modalities, options, stop);
    if (!isStopped(stop)) return made;
    // What was left half done may have labels above its count.
    return {Raster<std::uint32_t>(modalities.depth.width, modalities.depth.height, Segments::nothing), 0};
}

}  // namespace mote::render
