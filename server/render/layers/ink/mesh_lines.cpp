// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_lines.h"

#include <tbb/parallel_sort.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>

#include "server/render/ink/ink_line.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double partLength = 2.0;  // pixels of an edge that are seen or not as one
constexpr double mostParts = 4096.0;
constexpr double quickBeside = 1.0;   // pixels from a line at which what lies there is measured
constexpr double hidingShare = 2e-3;  // of the extent: what is so little nearer hides nothing

/// The same number, 0 to 1, of an edge in every picture.
float rankOf(const EdgeLine& edge) {
    std::uint64_t mixed = (std::uint64_t{edge.triangles[0]} << 32U | edge.vertices[0]) ^
                          (std::uint64_t{edge.vertices[1]} << 16U);
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBU;
    return static_cast<float>((mixed ^ (mixed >> 31U)) >> 40U) * 0x1p-24F;
}

class QuickFinder {
  public:
    QuickFinder(const MeshSurface& surface, const LineView& view, const Modalities& modalities)
        : surface_(surface), view_(view), depth_(modalities.depth), extent_(modalities.extent) {}

    void find(const EdgeLine& edge, std::vector<InkLine>& lines) const {
        const Ends ends = partOf(endsOf(surface_, edge, view_), edge.piece);
        const glm::dvec3 &from = ends.from, &to = ends.to;
        const glm::dvec2 a = view_.onScreen(from), b = view_.onScreen(to);
        const auto parts =
            static_cast<int>(std::clamp(std::ceil(glm::distance(a, b) / partLength), 1.0, mostParts));
        const auto placeAt = [&](double share) {
            const glm::dvec3 place = from + view_.alongLine(from, to, share) * (to - from);
            return LinePoint{view_.onScreen(place), -place.z};
        };
        InkLine line{edge.kind, {}, rankOf(edge)};
        for (int part = 0; part < parts; ++part) {
            const auto middle = placeAt((part + 0.5) / parts);
            if (!seen(middle, edge.kind, b - a)) {
                end(line, lines);
                continue;
            }
            if (line.points.empty()) line.points.push_back(placeAt(static_cast<double>(part) / parts));
            line.points.back().step = stepBeside(middle, b - a);
            line.points.push_back(placeAt((part + 1.0) / parts));
            line.points.back().step = line.points.front().step;
        }
        end(line, lines);
    }

  private:
    static void end(InkLine& line, std::vector<InkLine>& lines) {
        if (!line.points.empty()) lines.push_back(line);
        line.points.clear();
    }
    /// In the pixel of a silhouette the surface may bulge before it; beside it, it does not.
    bool seen(const LinePoint& place, LineKind kind, const glm::dvec2& way) const {
        const double least = place.depth - hidingShare * extent_;
        return depthAt(place.at) >= least || (kind == LineKind::silhouette && farthest(place, way) >= least);
    }
    double stepBeside(const LinePoint& place, const glm::dvec2& way) const {
        return std::clamp((farthest(place, way) - place.depth) / extent_, 0.0, 1.0);
    }
    /// Of what lies beside a line.
    double farthest(const LinePoint& place, const glm::dvec2& way) const {
        const double length = glm::length(way);
        if (!(length > 0.0)) return place.depth;
        const glm::dvec2 across = quickBeside / length * glm::dvec2(-way.y, way.x);
        return std::max(depthAt(place.at + across), depthAt(place.at - across));
    }
    double depthAt(const glm::dvec2& place) const {
        return static_cast<double>(depth_.near(place.x, place.y));
    }

    const MeshSurface& surface_;
    const LineView& view_;
    const Raster<float>& depth_;
    const double extent_;
};

constexpr double measured = 8.0;     // pixels of a line that share a depth step
constexpr double beside = 0.75;      // pixels from a line at which it is measured
constexpr double straightest = 0.2;  // cosine of the sharpest turn that a line takes
constexpr std::size_t crowd = 16;    // lines that meet in a place and are still told apart

constexpr std::size_t piecesATime = 256;  // that a thread takes

constexpr std::uint32_t nowhere = UINT32_MAX;

/// A piece on the screen.
struct Link {
    LineKind kind = LineKind::silhouette;
    std::vector<LinePoint> points;
    std::array<std::uint32_t, 2> places{nowhere, nowhere};  // at its ends, where a vertex is
    std::array<std::uint32_t, 2> next{nowhere, nowhere};    // the link that follows there
    bool taken = false;

    const glm::dvec2& end(std::size_t side) const { return side == 0 ? points.front().at : points.back().at; }
    /// Away from the end, along the link.
    glm::dvec2 inward(std::size_t side) const {
        const auto& other = side == 0 ? points[1].at : points[points.size() - 2].at;
        const glm::dvec2 way = other - end(side);
        const double length = glm::length(way);
        return length > 0.0 ? way / length : glm::dvec2(0.0);
    }
};

/// A piece's way on the screen; its depth steps are not told yet.
Link linkOf(const MeshSurface& surface, const LineView& view, const EdgeLine& piece) {
    // The whole edge may reach behind the eye.
    const auto [from, to] = partOf(endsOf(surface, piece, view), piece.piece);
    const double length = glm::distance(view.onScreen(from), view.onScreen(to));
    const auto parts = static_cast<std::size_t>(std::clamp(std::ceil(length / measured), 1.0, 4096.0));
    Link link;
    link.kind = piece.kind;
    for (std::size_t i = 0; i <= parts; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(parts);
        const glm::dvec3 place = from + view.alongLine(from, to, share) * (to - from);
        link.points.push_back({view.onScreen(place), -place.z});
    }
    return link;
}

/// Finds the depth steps beside segments of links, several at a time; one thread's.
class StepFinder {
  public:
    StepFinder(const MeshSurface& surface, const LineView& view, double extent)
        : surface_(surface), view_(view), extent_(extent) {}

    void find(std::span<Link> links) {
        for (auto& link : links) {
            for (std::size_t i = 0; i + 1 < link.points.size(); ++i) add(link.points[i], link.points[i + 1]);
        }
        measure();
        for (auto& link : links) link.points.back().step = link.points[link.points.size() - 2].step;
    }

  private:
    static constexpr std::size_t most = MeshRays::packet / 2;

    void add(LinePoint& from, const LinePoint& to) {
        const glm::dvec2 way = to.at - from.at;
        const double length = glm::length(way);
        if (!(length > 0.0)) return;
        const glm::dvec2 across = beside / length * glm::dvec2(-way.y, way.x);
        const glm::dvec2 middle = 0.5 * (from.at + to.at);
        for (const auto& place : {middle + across, middle - across}) {
            auto& ray = rays_[asked_++];
            ray = view_.through(place);
            ray.clip(surface_.rays().box());
        }
        points_[asked_ / 2 - 1] = {&from, 0.5 * (from.depth + to.depth)};
        if (asked_ == rays_.size()) measure();
    }
    void measure() {
        std::fill(rays_.begin() + static_cast<std::ptrdiff_t>(asked_), rays_.end(), MeshRay{});
        surface_.rays().first(rays_, met_);
        const auto depth = [&](const MeshMeeting& met) {
            return met.triangle == MeshMeeting::none ? HUGE_VAL : met.at;
        };
        for (std::size_t i = 0; 2 * i < asked_; ++i) {
            const double farthest = std::max(depth(met_[2 * i]), depth(met_[2 * i + 1]));
            points_[i].point->step = std::clamp((farthest - points_[i].depth) / extent_, 0.0, 1.0);
        }
        asked_ = 0;
    }

    struct Asked {
        LinePoint* point;
        double depth;
    };
    const MeshSurface& surface_;
    const LineView& view_;
    const double extent_;
    std::array<MeshRay, MeshRays::packet> rays_{};
    std::array<MeshMeeting, MeshRays::packet> met_{};
    std::array<Asked, most> points_{};
    std::size_t asked_ = 0;
};

using Place = std::tuple<double, double, double>;

Place placeOf(const glm::dvec3& at) {
    return {at.x, at.y, at.z};
}

/// An end of a link.
struct LinkEnd {
    std::uint32_t link;
    std::uint32_t side;
};

/// Of links that meet in a place, the straightest pairs follow one another.
void join(std::vector<Link>& links, std::span<const LinkEnd> meeting) {
    if (meeting.size() < 2 || meeting.size() > crowd) return;
    std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i < meeting.size(); ++i) {
        for (std::size_t k = i + 1; k < meeting.size(); ++k) {
            const Link &a = links[meeting[i].link], &b = links[meeting[k].link];
            if (a.kind != b.kind || meeting[i].link == meeting[k].link) continue;
            const double turn = glm::dot(a.inward(meeting[i].side), b.inward(meeting[k].side));
            if (turn <= -straightest) pairs.emplace_back(turn, i, k);
        }
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [turn, i, k] : pairs) {
        auto& one = links[meeting[i].link].next[meeting[i].side];
        auto& other = links[meeting[k].link].next[meeting[k].side];
        if (one != nowhere || other != nowhere) continue;
        one = meeting[k].link;
        other = meeting[i].link;
    }
}

/// `places`: how many there are.
void joinAll(std::vector<Link>& links, std::uint32_t places) {
    std::vector<std::uint32_t> begins(std::size_t{places} + 1, 0);
    const auto eachEnd = [&](const auto& take) {
        for (std::uint32_t i = 0; i < links.size(); ++i) {
            for (std::uint32_t side = 0; side < 2; ++side) {
                if (links[i].places[side] != nowhere) take(links[i].places[side], LinkEnd{i, side});
            }
        }
    };
    eachEnd([&](std::uint32_t place, const LinkEnd&) { ++begins[place + 1]; });
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::vector<LinkEnd> ends(begins.back());
    auto next = begins;
    eachEnd([&](std::uint32_t place, const LinkEnd& end) { ends[next[place]++] = end; });
    // Each end is in one place.
    forRangesInTurns(places, piecesATime, [&](const auto& run) {
        for (auto place = run.begin(); place < run.end(); ++place)
            join(links, std::span(ends).subspan(begins[place], begins[place + 1] - begins[place]));
    });
}

/// Appends a link's points, from one of its ends to the other.
void append(const Link& link, std::size_t side, std::vector<LinePoint>& points) {
    std::vector<LinePoint> more = link.points;
    if (side == 1) {
        std::reverse(more.begin(), more.end());
        for (std::size_t i = 0; i + 1 < more.size(); ++i) more[i].step = more[i + 1].step;
    }
    if (!points.empty()) points.pop_back();
    points.insert(points.end(), more.begin(), more.end());
}

/// From one end of a link on, as far as links follow.
InkLine follow(std::vector<Link>& links, std::uint32_t first, std::size_t side) {
    InkLine line{links[first].kind, {}};
    for (std::uint32_t at = first; at != nowhere && !links[at].taken;) {
        links[at].taken = true;
        append(links[at], side, line.points);
        const std::uint32_t next = links[at].next[1 - side];
        if (next != nowhere) {
            const auto place = links[at].places[1 - side];
            side = links[next].places[0] == place && links[next].next[0] == at ? 0 : 1;
        }
        at = next;
    }
    return line;
}

/// Vertices in one place have one number; how many there are.
std::uint32_t numberPlaces(const MeshSurface& surface, const std::vector<EdgeLine>& pieces,
                           std::vector<Link>& links) {
    std::vector<std::tuple<Place, std::uint32_t, std::uint32_t>> ends;
    for (std::uint32_t i = 0; i < pieces.size(); ++i) {
        const Span& span = pieces[i].piece;
        if (span.begin == 0.0) ends.emplace_back(placeOf(pieces[i].end(surface, 0)), i, 0);
        if (span.end == 1.0) ends.emplace_back(placeOf(pieces[i].end(surface, 1)), i, 1);
    }
    tbb::parallel_sort(ends.begin(), ends.end());
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const auto& [place, link, side] = ends[i];
        if (i > 0 && std::get<0>(ends[i - 1]) != place) ++number;
        links[link].places[side] = number;
    }
    return ends.empty() ? 0 : number + 1;
}

glm::dvec3 area(const storage::SurfaceMesh& mesh, std::uint32_t triangle) {
    const auto [i, j, k] = mesh.triangles[triangle];
    const glm::dvec3 a(mesh.positions[i]);
    return glm::cross(glm::dvec3(mesh.positions[j]) - a, glm::dvec3(mesh.positions[k]) - a);
}

/// On which side of each triangle the eye is: 1, -1, or 0.
std::vector<std::int8_t> facings(const storage::SurfaceMesh& mesh, const LineView& view) {
    std::vector<std::int8_t> sides(mesh.triangles.size());
    forRangesInTurns(sides.size(), 1024, [&](const auto& range) {
        for (auto i = range.begin(); i < range.end(); ++i) {
            const auto [a, b, c] = mesh.triangles[i];
            const double side = view.facing(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
            sides[i] = static_cast<std::int8_t>((side > 0.0) - (side < 0.0));
        }
    });
    return sides;
}

class LineFinder {
  public:
    LineFinder(const MeshSurface& surface, const LineView& view, double crease)
        : surface_(surface),
          mesh_(surface.mesh()),
          view_(view),
          creases_(crease < 180.0),
          leastCosine_(std::cos(crease * std::numbers::pi / 180.0)),
          sides_(facings(mesh_, view)) {}

    std::size_t count() const { return mesh_.edges.size() + (creases_ ? mesh_.intersections.size() : 0); }

    void find(std::size_t first, std::size_t last, std::vector<EdgeLine>& lines) const {
        for (std::size_t i = first; i < last; ++i) {
            EdgeLine line = i < mesh_.edges.size() ? edgeOf(i) : intersectionOf(i - mesh_.edges.size());
            if (i < mesh_.edges.size() && !isLine(mesh_.edges[i], line.kind)) continue;
            const auto [from, to] = endsOf(surface_, line, view_);
            line.piece = view_.inPicture(from, to, lineMargin);
            if (!line.piece.empty()) lines.push_back(line);
        }
    }

  private:
    EdgeLine edgeOf(std::size_t number) const {
        const auto& edge = mesh_.edges[number];
        return {.vertices = edge.vertices, .triangles = edge.triangles};
    }
    EdgeLine intersectionOf(std::size_t number) const {
        const auto first = static_cast<std::uint32_t>(mesh_.positions.size() + 2 * number);
        return {.kind = LineKind::crease,
                .vertices = {first, first + 1},
                .triangles = mesh_.intersections[number]};
    }
    bool isLine(const storage::MeshEdge& edge, LineKind& kind) const {
        const auto [one, other] = edge.triangles;
        if (one == storage::MeshEdge::none || other == storage::MeshEdge::none) {
            kind = LineKind::border;
            return true;
        }
        // If one is seen edge-on it counts with those that are seen.
        if ((sides_[one] < 0) != (sides_[other] < 0)) {
            kind = LineKind::silhouette;
            return true;
        }
        kind = LineKind::crease;
        return creases_ && bends(one, other);
    }
    bool bends(std::uint32_t one, std::uint32_t other) const {
        const glm::dvec3 a = area(mesh_, one), b = area(mesh_, other);
        const double lengths = glm::length(a) * glm::length(b);
        return lengths > 0.0 && glm::dot(a, b) <= leastCosine_ * lengths;
    }

    const MeshSurface& surface_;
    const storage::SurfaceMesh& mesh_;
    const LineView& view_;
    const bool creases_;
    const double leastCosine_;
    std::vector<std::int8_t> sides_;
};

}  // namespace

std::vector<InkLine> quickLines(const MeshSurface& surface, const LineView& view,
                                const std::vector<EdgeLine>& edges, const Modalities& modalities,
                                const std::stop_token& stop) {
    const QuickFinder finder(surface, view, modalities);
    return inOrder<InkLine>(edges.size(), stop, [&](std::size_t first, std::size_t last, auto& lines) {
        for (std::size_t i = first; i < last; ++i) finder.find(edges[i], lines);
    });
}

std::vector<InkLine> chained(const MeshSurface& surface, const LineView& view,
                             const std::vector<EdgeLine>& pieces, std::optional<double> extent,
                             const std::stop_token& stop) {
    std::vector<Link> links(pieces.size());
    forRangesInTurns(pieces.size(), piecesATime, [&](const auto& run) {
        if (isStopped(stop)) return;
        for (auto i = run.begin(); i < run.end(); ++i) links[i] = linkOf(surface, view, pieces[i]);
        if (extent)
            StepFinder(surface, view, *extent).find(std::span(links).subspan(run.begin(), run.size()));
    });
    if (isStopped(stop)) return {};
    joinAll(links, numberPlaces(surface, pieces, links));
    std::vector<InkLine> lines;
    const auto take = [&](std::uint32_t i, std::size_t side) {
        giveWay();
        lines.push_back(follow(links, i, side));
    };
    for (std::uint32_t i = 0; i < links.size(); ++i) {
        for (std::size_t side = 0; side < 2; ++side) {
            if (!links[i].taken && links[i].next[side] == nowhere) take(i, side);
        }
    }
    for (std::uint32_t i = 0; i < links.size(); ++i) {
        if (!links[i].taken) take(i, 0);  // closed
    }
    forInTurns(std::size_t{0}, lines.size(), [&](std::size_t i) { simplify(lines[i].points); });
    return lines;
}

std::vector<EdgeLine> linesOf(const MeshSurface& surface, const LineView& view, double crease,
                              const std::stop_token& stop) {
    const LineFinder finder(surface, view, crease);
    return inOrder<EdgeLine>(finder.count(), stop, [&](std::size_t first, std::size_t last, auto& lines) {
        finder.find(first, last, lines);
    });
}

}  // namespace mote::render
