// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments.h"

#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_cut.h"
#include "server/render/ink/segments_graph.h"
#include "server/render/ink/segments_growing.h"
#include "server/render/ink/segments_texture.h"

namespace mote::render {

Segments segmentsOf(const Modalities& modalities, const SegmentOptions& options,
                    const std::stop_token& stop) {
    const auto parted = [&] {
        switch (options.method) {
            case Segmentation::graph:
                return graphSegments(modalities, stop);
            case Segmentation::cut:
                return cutSegments(modalities, options.leastPixels, stop);
            case Segmentation::texture:
                return textureSegments(modalities, options.leastPixels, stop);
            default:
                return grownSegments(modalities, {}, options.leastPixels, stop);
        }
    };
    auto made = withoutSmall(parted(), modalities, options.leastPixels, stop);
    if (!stop.stop_requested()) return made;
    // What was left half done may have labels above its count.
    return {Raster<std::uint32_t>(modalities.depth.width, modalities.depth.height, Segments::nothing), 0};
}

}  // namespace mote::render
