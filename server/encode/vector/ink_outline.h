// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkOutline: the outline of a line whose width changes, for sheets, which know lines of one width only. A
// value; one thread.
#pragma once

#include <vector>

#include "server/encode/vector/page_paths.h"
#include "server/render/plan/stroke.h"

namespace mote::server {

class InkOutline {
  public:
    /// Whether the way to a point bends so sharply at the last one that its outline would not follow.
    bool bendsTo(const render::StrokePoint& point) const;
    /// A point at the place of the last one is left out.
    void add(const render::StrokePoint& point);
    const render::StrokePoint& last() const { return points_.back(); }
    /// Appends the outline, which goes round in the same direction for all lines, and forgets the line.
    void finish(PagePaths& outlines);

  private:
    glm::dvec2 wayTo(std::size_t index) const;

    std::vector<render::StrokePoint> points_;
};

}  // namespace mote::server
