// SPDX-License-Identifier: GPL-3.0-or-later
//
// EdgeLine: an edge of a mesh, an intersection of two of its triangles, or a suggestive contour within one,
// that is a line of a drawing, or a piece of one. A value; pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <iterator>
#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {

/// Pixels beside the picture in which lines are still looked for.
inline constexpr double lineMargin = 64.0;

struct EdgeLine {
    LineKind kind = LineKind::silhouette;
    std::array<std::uint32_t, 2> vertices{}, triangles{};  ///< MeshSurface::place(); storage::MeshEdge
    Span piece{0.0, 1.0};                                  ///< of the edge, world space
    std::array<glm::dvec3, 2> ends{};  ///< of a suggestive contour, layer space, which has no vertices

    glm::dvec3 end(const MeshSurface& surface, std::size_t side) const {
        return kind == LineKind::suggestive ? ends[side] : surface.place(vertices[side]);
    }
};

/// Of a line, eye space.
struct Ends {
    glm::dvec3 from, to;
};

/// Of the whole edge, which may reach behind the eye.
inline Ends endsOf(const MeshSurface& surface, const EdgeLine& edge, const LineView& view) {
    return {view.toEye(edge.end(surface, 0)), view.toEye(edge.end(surface, 1))};
}

inline Ends partOf(const Ends& ends, const Span& span) {
    return {ends.from + span.begin * (ends.to - ends.from), ends.from + span.end * (ends.to - ends.from)};
}

/// Calls make(first, last, list) for runs of a list of `count` on many threads; all that they make, in order.
template <class T, class Make>
std::vector<T> inOrder(std::size_t count, const std::stop_token& stop, const Make& make) {
    constexpr std::size_t atATime = 1024;
    std::vector<std::vector<T>> made((count + atATime - 1) / atATime);
    forInTurns(std::size_t{0}, made.size(), [&](std::size_t run) {
        if (isStopped(stop)) return;
        const std::size_t first = run * atATime;
        make(first, std::min(first + atATime, count), made[run]);
    });
    std::vector<T> all;
    for (auto& run : made)
        all.insert(all.end(), std::make_move_iterator(run.begin()), std::make_move_iterator(run.end()));
    return all;
}

}  // namespace mote::render
