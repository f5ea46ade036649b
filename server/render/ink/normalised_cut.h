// SPDX-License-Identifier: GPL-3.0-or-later
//
// Normalised cuts of a graph (Shi and Malik 2000, Normalized Cuts and Image Segmentation): in two, and each
// side again. Pure; deterministic, on any processor.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "server/render/ink/region_graph.h"

namespace mote::render {

struct CutOptions {
    double meanAffinity = 0.5;  ///< of pairs across a cut that stands, less than this
    double cost = 0.1;          ///< of such a cut: affinity across by that to all nodes, of both sides; less
    std::size_t vectors = 8;    ///< eigenvectors along which cuts are tried
};

/// Of each node the number of the group that it is in; each is connected. Of all cuts along an eigenvector
/// of the normalised affinities (those with the greatest eigenvalues) the cheapest is taken that may stand.
/// If the whole takes too long, what was not cut yet is left as single nodes, and so is
/// that of which no eigenvector is found.
std::vector<std::uint32_t> normalisedCuts(const RegionGraph& graph, const CutOptions& options,
                                          const std::stop_token& stop);

}  // namespace mote::render
