// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a frame says beside what it shows (docs/PICTURE.md, "Annotations"): boxes with ticks, colour bars, a
// scale bar, words, as marks in pixels of the view. A pure function, any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/transfer_function.h"
#include "protocol/scene/view.h"
#include "server/figures/marks.h"

namespace mote::server {

/// What is known of a layer beside the view.
struct LayerFacts {
    std::shared_ptr<const proto::Manifest> manifest;  ///< of its dataset; null: nothing is said of it
    std::optional<TransferFunction> transfer = {};    ///< of its volume, if one is seen
    std::optional<ValueRange> colorRange = {};        ///< of the values that points are coloured by
    std::optional<std::uint64_t> chosen = {};         ///< particles of its selection
    std::optional<std::uint64_t> highlighted = {};    ///< particles that are drawn over the others
    std::optional<glm::dvec3> points = {};  ///< linear RGB of its points, if they have one and are seen
    std::optional<Bounds> shown = {};  ///< of a plot, what its axes are of, layer space; absent: all of it
};

/// `view`: with its camera, as it is drawn, and with annotations; `layers`: one a layer.
Marks annotate(const View& view, const std::vector<LayerFacts>& layers);

}  // namespace mote::server
