// SPDX-License-Identifier: GPL-3.0-or-later
//
// The box around a particle plot as a picture shows it: its outermost edges and those that lie
// behind the plot, with ticks and labels beside an outermost one of each axis; or, where none is in the
// picture, beside one that lies behind. A function that adds marks.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <string>

#include "protocol/scene/view.h"
#include "server/figures/annotation_room.h"

namespace mote::server {

struct PlotBox {
    struct Axis {
        std::string name;  ///< a column or derived quantity
        std::string unit;
        double min = 0.0, max = 1.0;

        bool operator==(const Axis&) const = default;
    };
    std::array<Axis, 3> axes;
    glm::dmat4 transform{1.0};  ///< layer space, in which it is plotBounds, to world space

    bool operator==(const PlotBox&) const = default;
};

/// Of an axis that is seen end on there are no labels, and none where the eye is in the box. A label that
/// would lie beyond the picture's edge, or over another, is left out.
void addPlotBox(const PlotBox& box, const View& view, AnnotationRoom& room);

}  // namespace mote::server
