// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_chains.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <span>
#include <tuple>

#include "server/render/ink/ink_line.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

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

Place placeOf(const MeshSurface& surface, std::uint32_t vertex) {
    const glm::dvec3 at = surface.place(vertex);
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
        if (span.begin == 0.0) ends.emplace_back(placeOf(surface, pieces[i].vertices[0]), i, 0);
        if (span.end == 1.0) ends.emplace_back(placeOf(surface, pieces[i].vertices[1]), i, 1);
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

}  // namespace

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

}  // namespace mote::render
