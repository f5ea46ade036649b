// SPDX-License-Identifier: GPL-3.0-or-later
//
// Segments: a picture parted into regions that are drawn with one kind of stroke (the dissertation's sections
// 2.3.1 and 2.3.6.1). Pure; deterministic on any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/modalities.h"

namespace mote::render {

struct Segments {
    static constexpr std::uint32_t nothing = UINT32_MAX;

    Raster<std::uint32_t> label;  ///< below `count`; `nothing` where nothing is seen
    std::uint32_t count = 0;
    /// In which regions are hatched that somebody says it of, radians from the picture's x axis to its
    /// (downward) y axis; of the first labels.
    std::vector<std::optional<double>> directions = {};
};

struct SegmentOptions {
    Segmentation method = Segmentation::growing;
    std::size_t leastPixels = 36;
};

/// Regions by any of the methods, each connected; those of fewer than `leastPixels` have become part of
/// neighbours. Where nothing is seen, no region. If `stop` is requested meanwhile, none at
/// all.
Segments segmentsOf(const Modalities& modalities, const SegmentOptions& options, const std::stop_token& stop);

}  // namespace mote::render
