// SPDX-License-Identifier: GPL-3.0-or-later
//
// A colour bar: which colour stands for which value, upright, with an axis on its right. A pure function that
// adds marks.
#pragma once

#include <functional>

#include "server/figures/marks.h"
#include "server/figures/plot_axis.h"

namespace mote::server {

/// `color`: linear RGB, by the share of the way from the low end to the high one.
void addColorBar(const Box& box, const PlotAxis& axis, const std::function<glm::dvec3(double)>& color,
                 const PlotLook& look, const Typeface& typeface, Marks& marks);

}  // namespace mote::server
