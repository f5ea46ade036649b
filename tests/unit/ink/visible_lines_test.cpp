// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which edges are lines and what is seen of them, compared with a plain trial of all triangles in eye space,
// place by place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t width = 96, height = 72;
constexpr double every = 0.3;    // pixels between places that are tried
constexpr double crease = 60.0;  // degrees
constexpr auto none = storage::MeshEdge::none;

enum class Drawn { no, yes, undecided };

/// The plain trial.
class Oracle {
  public:
    Oracle(const storage::SurfaceMesh& mesh, const FramePlan& plan, const glm::dmat4& transform)
        : mesh_(mesh),
          perspective_(plan.camera.perspective()),
          nearest_(perspective_ ? 1e-3 * glm::distance(plan.camera.eye, plan.camera.target) : -HUGE_VAL),
          scale_(0.5 * height / plan.camera.halfHeight()) {
        const glm::dmat4 toEye = plan.camera.worldToEye() * transform;
        turn_ = glm::dmat3(toEye);
        glm::dvec3 least(HUGE_VAL), most(-HUGE_VAL);
        for (const auto& at : mesh.positions) {
            eye_.emplace_back(toEye * glm::dvec4(glm::dvec3(at), 1.0));
            least = glm::min(least, eye_.back());
            most = glm::max(most, eye_.back());
        }
        size_ = glm::distance(least, most);
    }

    Drawn drawn(const storage::MeshEdge& edge, LineKind& kind) const {
        kind = LineKind::border;
        if (edge.triangles[0] == none || edge.triangles[1] == none) return Drawn::yes;
        const double one = side(edge.triangles[0]), other = side(edge.triangles[1]);
        if (std::min(std::abs(one), std::abs(other)) < 1e-9) return Drawn::undecided;
        kind = LineKind::silhouette;
        if ((one > 0.0) != (other > 0.0)) return Drawn::yes;
        kind = LineKind::crease;
        const double turn = glm::degrees(
            std::acos(std::clamp(glm::dot(normal(edge.triangles[0]), normal(edge.triangles[1])), -1.0, 1.0)));
        if (std::abs(turn - crease) < 1e-5) return Drawn::undecided;
        return turn > crease ? Drawn::yes : Drawn::no;
    }

    /// Calls take(share of the edge, whether it is seen) for places of an edge in the picture.
    template <class Take>
    void places(const storage::MeshEdge& edge, const Take& take) const {
        glm::dvec3 a = eye_[edge.vertices[0]], b = eye_[edge.vertices[1]];
        double begin = 0.0, end = 1.0;
        if (-a.z < nearest_ && -b.z < nearest_) return;
        if (-a.z < nearest_) begin = (nearest_ + a.z) / (a.z - b.z);
        if (-b.z < nearest_) end = (nearest_ + a.z) / (a.z - b.z);
        const glm::dvec3 from = a + begin * (b - a), to = a + end * (b - a);
        const glm::dvec2 p = screen(from), q = screen(to);
        double first = 0.0, last = 1.0;
        for (int axis = 0; axis < 2; ++axis) {
            const double most = axis == 0 ? width : height, way = q[axis] - p[axis];
            if (way == 0.0 && (p[axis] < 0.0 || p[axis] > most)) return;
            if (way == 0.0) continue;
            first = std::max(first, std::min(-p[axis] / way, (most - p[axis]) / way));
            last = std::min(last, std::max(-p[axis] / way, (most - p[axis]) / way));
        }
        const auto count = static_cast<int>((last - first) * glm::distance(p, q) / every);
        for (int i = 0; i < count; ++i) {
            const double s = first + (last - first) * (i + 0.5) / count;
            const double share = perspective_ ? s / to.z / ((1.0 - s) / from.z + s / to.z) : s;
            take(begin + share * (end - begin), seen(from + share * (to - from), edge.triangles));
        }
    }

  private:
    glm::dvec2 screen(const glm::dvec3& at) const {
        const double unit = perspective_ ? scale_ / -at.z : scale_;
        return {0.5 * width + unit * at.x, 0.5 * height - unit * at.y};
    }
    glm::dvec3 normal(std::uint32_t triangle) const {
        const auto [i, j, k] = mesh_.triangles[triangle];
        const glm::dvec3 a(mesh_.positions[i]);
        return glm::normalize(
            glm::cross(glm::dvec3(mesh_.positions[j]) - a, glm::dvec3(mesh_.positions[k]) - a));
    }
    /// The cosine of what is between a triangle's normal and the way to the eye.
    double side(std::uint32_t triangle) const {
        const auto [i, j, k] = mesh_.triangles[triangle];
        // Corners may be nearer to one another than eye space tells apart.
        const glm::dvec3 a(mesh_.positions[i]);
        const glm::dvec3 u = turn_ * (glm::dvec3(mesh_.positions[j]) - a),
                         v = turn_ * (glm::dvec3(mesh_.positions[k]) - a), area = glm::cross(u, v);
        const glm::dvec3 way = perspective_ ? -eye_[i] : glm::dvec3(0.0, 0.0, 1.0);
        // A needle has no side.
        if (!(glm::length(area) > 1e-9 * glm::length(u) * glm::length(v))) return 0.0;
        return glm::dot(glm::normalize(area), glm::normalize(way));
    }
    bool seen(const glm::dvec3& at, const std::array<std::uint32_t, 2>& own) const {
        const glm::dvec3 towards = perspective_ ? glm::normalize(-at) : glm::dvec3(0.0, 0.0, 1.0);
        for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
            if (i == own[0] || i == own[1]) continue;
            const auto& corners = mesh_.triangles[i];
            const glm::dvec3 a = eye_[corners[0]], u = eye_[corners[1]] - a, v = eye_[corners[2]] - a;
            const glm::dvec3 p = glm::cross(towards, v);
            const double turn = glm::dot(u, p);
            if (turn == 0.0) continue;
            const glm::dvec3 off = at - a, q = glm::cross(off, u);
            const double one = glm::dot(off, p) / turn, other = glm::dot(towards, q) / turn;
            if (one < 0.0 || other < 0.0 || one + other > 1.0) continue;
            const double away = glm::dot(v, q) / turn;
            if (away > 1e-6 * size_ && -(at + away * towards).z >= nearest_) return false;
        }
        return true;
    }

    const storage::SurfaceMesh& mesh_;
    const bool perspective_;
    const double nearest_, scale_;
    glm::dmat3 turn_{1.0};
    std::vector<glm::dvec3> eye_;
    double size_ = 0.0;
};

/// Places that were tried, and in how many of them both say the same.
struct Agreement {
    std::size_t places = 0, alike = 0, missed = 0, hidden = 0, lost = 0, whole = 0;
};

using EdgeKey = std::pair<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>>;

/// `likely`: what is seen in each pixel is tried first, and what lies far behind it is not tried.
void compare(const MeshSurface& surface, const FramePlan& plan, const glm::dmat4& transform, bool likely,
             Agreement& total) {
    const LineView view(plan, transform);
    const auto pictures = modalitiesOf(surface, transform, test::usualInk(), plan, {});
    const HiderSearch search{.sampling = 0.5,
                             .likely = likely ? &pictures.triangle : nullptr,
                             .farthest = likely ? &pictures.farthest : nullptr};
    const auto edges = linesOf(surface, view, crease, {});
    std::map<EdgeKey, LineKind> lines;
    for (const auto& edge : edges) lines[{edge.vertices, edge.triangles}] = edge.kind;
    std::map<EdgeKey, std::vector<Span>> pieces;
    for (const auto& piece : visible(surface, view, edges, search, {}))
        pieces[{piece.vertices, piece.triangles}].push_back(piece.piece);
    const Oracle oracle(surface.mesh(), plan, transform);
    for (const auto& edge : surface.mesh().edges) {
        LineKind kind{};
        const auto drawn = oracle.drawn(edge, kind);
        if (drawn == Drawn::undecided) continue;
        const EdgeKey key{edge.vertices, edge.triangles};
        std::size_t tried = 0, seenThere = 0, found = 0;
        oracle.places(edge, [&](double share, bool seen) {
            const auto& all = pieces[key];
            const bool has = std::any_of(all.begin(), all.end(), [&](const Span& span) {
                return span.begin <= share && share <= span.end;
            });
            const bool wanted = drawn == Drawn::yes && seen;
            ++tried;
            seenThere += wanted;
            found += has;
            total.hidden += drawn == Drawn::yes && !seen;
            if (drawn == Drawn::no && !has) return;
            ++total.places;
            total.alike += has == wanted;
            total.missed += wanted && !has;
        });
        if (tried == 0) continue;
        if (drawn == Drawn::yes) {
            ASSERT_TRUE(lines.contains(key)) << static_cast<int>(kind);
            EXPECT_EQ(static_cast<int>(lines[key]), static_cast<int>(kind));
        }
        if (seenThere < tried) continue;
        ++total.whole;
        if (found < tried) ++total.lost;
    }
}

TEST(VisibleLines, AreThoseThatATrialOfAllTrianglesFinds) {
    test::Random random(12);
    Agreement all;
    for (const auto form : test::meshForms()) {
        Agreement total;
        for (std::uint32_t number = 0; number < 4; ++number) {
            const auto surface = test::surfaceOf(test::meshOf(std::string(form), number, 0)->mesh());
            for (int i = 0; i < 12; ++i) {
                const auto transform = test::anyTransform(random);
                const auto camera = test::anyCamera(random, surface->bounds().transformed(transform));
                compare(*surface, test::planOf(camera, width, height), transform, i % 3 != 0, total);
            }
        }
        const double share = static_cast<double>(total.alike) / static_cast<double>(total.places);
        EXPECT_GE(share, 0.995) << form;
        // Narrow triangles may be missed; what is seen may not.
        EXPECT_LE(static_cast<double>(total.missed), 1e-4 * static_cast<double>(total.places)) << form;
        EXPECT_LE(static_cast<double>(total.lost), 0.002 * static_cast<double>(total.whole)) << form;
        all.places += total.places;
        all.hidden += total.hidden;
    }
    EXPECT_GT(all.places, 100000U);
    EXPECT_GT(all.hidden, 10000U);
}

TEST(VisibleLines, ARequestToStopIsHeard) {
    const auto surface = test::surfaceOf(test::meshOf("leaves", 0, 0)->mesh());
    const LineView view(test::planOf(fitCamera(surface->bounds(), 1.0), 64, 64), glm::dmat4(1.0));
    std::stop_source source;
    source.request_stop();
    EXPECT_TRUE(linesOf(*surface, view, crease, source.get_token()).empty());
    const auto edges = linesOf(*surface, view, crease, {});
    EXPECT_FALSE(edges.empty());
    EXPECT_TRUE(visible(*surface, view, edges, {.sampling = 0.5}, source.get_token()).empty());
    EXPECT_TRUE(chained(*surface, view, edges, 1.0, source.get_token()).empty());
}

}  // namespace
}  // namespace mote::render
