// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/numbers/plain_selection.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>
#include <set>

namespace mote::test {
namespace {

using All = std::vector<Chosen>;

Chosen opposite(Chosen one) {
    return one == Chosen::yes ? Chosen::no : one == Chosen::no ? Chosen::yes : Chosen::doubt;
}

template <class Test>
void both(All& all, const Test& test) {
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = std::min(all[i], test(i));
}

Chosen sure(bool yes) {
    return yes ? Chosen::yes : Chosen::no;
}

double placeOf(std::uint64_t morton, int axis) {
    double place = 0.0;
    for (int bit = 0; bit < 21; ++bit) {
        if ((morton >> (3 * bit + axis) & 1U) != 0) place += std::ldexp(1.0, bit);
    }
    return place;
}

/// Layer space, of each point.
std::vector<glm::dvec3> places(const MemoryStep& step) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    std::vector<glm::dvec3> all;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto node = leaves.node[leaf];
        for (const auto& p : step.positions(leaves.pointBegin[leaf], leaves.pointCount[leaf])) {
            const double part[3] = {(p.x + 0.5) / 65536, (p.y + 0.5) / 65536, (p.z + 0.5) / 65536};
            glm::dvec3 place;
            for (int axis = 0; axis < 3; ++axis) {
                const double inBox =
                    std::ldexp(placeOf(nodes.morton[node], axis) + part[axis], -nodes.level[node]);
                place[axis] = 2.0 * inBox - 1.0;
            }
            all.push_back(place);
        }
    }
    return all;
}

std::vector<double> densities(const MemoryStep& step) {
    const auto leaves = step.leaves();
    std::vector<double> all;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf)
        all.insert(all.end(), leaves.pointCount[leaf], step.logDensity().ofLeaf(leaves.density[leaf]));
    return all;
}

Chosen inLasso(const Selection::Lasso& lasso, const glm::dvec3& place) {
    for (const auto& plane : lasso.clip ? lasso.clip->planes() : ClipPlanes()) {
        double within = -plane.distance();
        for (int i = 0; i < 3; ++i) within += plane.normal(i) * place[i];
        if (std::abs(within) < 1e-12) return Chosen::doubt;
        if (within < 0.0) return Chosen::no;
    }
    const auto& camera = lasso.camera;
    const glm::dvec4 eye =
        glm::lookAt(camera.eye, camera.target, camera.up) * (lasso.transform * glm::dvec4(place, 1.0));
    const double depth = -eye.z;
    double half = camera.orthographicHeight.value_or(0.0) / 2.0;
    if (!camera.orthographicHeight) {
        const double nearest = 1e-3 * glm::length(camera.target - camera.eye);
        if (std::abs(depth - nearest) < 1e-12) return Chosen::doubt;
        if (depth < nearest) return Chosen::no;
        half = std::tan(glm::radians(camera.fovYDegrees) / 2.0) * depth;
    }
    const double x = (eye.x / (half * lasso.aspect) + 1.0) / 2.0, y = (1.0 - eye.y / half) / 2.0;
    const bool inside = plainInside(lasso.points, x, y);
    const double little = 1e-10 * (1.0 + std::abs(x) + std::abs(y));
    for (const auto& [dx, dy] : {std::pair{little, 0.0}, {-little, 0.0}, {0.0, little}, {0.0, -little}}) {
        if (plainInside(lasso.points, x + dx, y + dy) != inside) return Chosen::doubt;
    }
    return sure(inside);
}

/// Where the plot of a lasso shows each particle, layer space; NaN where it shows none.
std::vector<glm::dvec3> placesBy(const std::vector<Selection::PlotAxis>& plot, const MemoryRun& run,
                                 std::uint32_t step) {
    constexpr double rounding =
        2e-6;  // docs/SELECTIONS.md: what lies within a millionth of the edge is shown
    std::vector<glm::dvec3> all(run.at(step).points->pointCount());
    for (int axis = 0; axis < 3; ++axis) {
        const auto& [column, min, max] = plot[static_cast<std::size_t>(axis)];
        const auto values = plainQuantity(column, run, step);
        for (std::size_t i = 0; i < all.size(); ++i) {
            all[i][axis] = (2.0 * values[i] - min - max) / (max - min);
            if (std::abs(all[i][axis]) > 1.0 + rounding) all[i] = glm::dvec3(NAN);
        }
    }
    return all;
}

/// The emittances, and the one from which on they are the share of the weight.
All outermost(const Selection::Outermost& wanted, const MemoryRun& run, std::uint32_t step) {
    const std::string name(1, wanted.plane);
    const auto q = plainQuantity(name, run, step), p = plainQuantity("p" + name, run, step);
    const auto weight = plainQuantity("weight", run, step);
    All all(q.size(), Chosen::no);
    std::vector<std::size_t> counted;
    long double sum = 0, meanQ = 0, meanP = 0, qq = 0, qp = 0, pp = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
        if (!(weight[i] > 0.0) || !std::isfinite(q[i]) || !std::isfinite(p[i])) continue;
        counted.push_back(i);
        sum += weight[i];
        meanQ += static_cast<long double>(weight[i]) * q[i];
        meanP += static_cast<long double>(weight[i]) * p[i];
    }
    if (!(sum > 0) || wanted.share <= 0.0) return all;
    meanQ /= sum;
    meanP /= sum;
    for (const auto i : counted) {
        qq += weight[i] * (q[i] - meanQ) * (q[i] - meanQ) / sum;
        qp += weight[i] * (q[i] - meanQ) * (p[i] - meanP) / sum;
        pp += weight[i] * (p[i] - meanP) * (p[i] - meanP) / sum;
    }
    const auto emittance = [&](std::size_t i) {
        const long double a = q[i] - meanQ, b = p[i] - meanP;
        return static_cast<double>(pp * a * a - 2 * qp * a * b + qq * b * b);
    };
    std::ranges::sort(counted, std::greater<>(), emittance);
    long double before = 0;
    double threshold = 0.0;
    bool close = false;  // the share ends at a particle's border: rounding decides
    for (const auto i : counted) {
        threshold = emittance(i);
        before += weight[i];
        close = std::abs(static_cast<double>(before - wanted.share * sum)) < 1e-9 * static_cast<double>(sum);
        if (close || before >= wanted.share * sum) break;
    }
    const double scale = 1e-9 * std::max(threshold, static_cast<double>(qq * pp));
    for (std::size_t i = 0; i < q.size(); ++i) {
        if (!std::isfinite(q[i]) || !std::isfinite(p[i])) continue;
        const double own = emittance(i);
        if (std::abs(own - threshold) <= scale)
            all[i] = Chosen::doubt;
        else
            all[i] = sure(own > threshold);
    }
    if (close) {
        // The next one may belong to it.
        double next = -1.0;
        for (const auto i : counted) {
            if (emittance(i) < threshold - scale) next = std::max(next, emittance(i));
        }
        for (std::size_t i = 0; i < q.size(); ++i) {
            if (std::isfinite(q[i]) && std::isfinite(p[i]) && emittance(i) <= threshold + scale &&
                emittance(i) >= next - scale)
                all[i] = Chosen::doubt;
        }
    }
    return all;
}

}  // namespace

bool plainInside(const std::vector<glm::dvec2>& corners, double x, double y) {
    bool inside = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        auto a = corners[i], b = corners[(i + 1) % corners.size()];
        if (a.y > b.y) std::swap(a, b);
        if (!(a.y <= y && y < b.y)) continue;
        const double at = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
        if (x < std::clamp(at, std::min(a.x, b.x), std::max(a.x, b.x))) inside = !inside;
    }
    return inside;
}

std::vector<double> plainQuantity(const std::string& name, const MemoryRun& run, std::uint32_t step) {
    const auto& columns = *run.at(step).columns;
    std::vector<double> values(columns.pointCount());
    if (const auto column = columns.find(name)) {
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = columns.value(*column, i);
        return values;
    }
    const auto* const derived = findKnownQuantity(name);
    for (std::size_t i = 0; i < values.size(); ++i) {
        std::vector<double> parts;
        for (const auto part : derived->columns) parts.push_back(columns.value(*columns.find(part), i));
        std::vector<std::span<const double>> spans;
        for (const auto& part : parts) spans.emplace_back(&part, 1);
        derived->formula(spans, run.context(), std::span(&values[i], 1));
    }
    return values;
}

std::vector<Chosen> plainSelection(const Selection& selection, const MemoryRun& run, std::uint32_t step) {
    const auto& here = run.at(step);
    All all(here.points->pointCount(), selection.nothing ? Chosen::no : Chosen::yes);
    if (selection.step && *selection.step != step) {
        const auto there = plainSelection(selection, run, *selection.step);
        const auto ids = run.at(*selection.step).columns->ids(0, there.size());
        std::set<std::uint64_t> chosen, doubtful;
        for (std::size_t i = 0; i < there.size(); ++i) {
            if (there[i] == Chosen::yes) chosen.insert(ids[i]);
            if (there[i] == Chosen::doubt) doubtful.insert(ids[i]);
        }
        const auto own = here.columns->ids(0, all.size());
        both(all, [&](std::size_t i) {
            return chosen.contains(own[i])     ? Chosen::yes
                   : doubtful.contains(own[i]) ? Chosen::doubt
                                               : Chosen::no;
        });
        return all;
    }
    for (const auto& range : selection.ranges) {
        const auto values = plainQuantity(range.column, run, step);
        both(all, [&](std::size_t i) { return sure(values[i] >= range.min && values[i] <= range.max); });
    }
    if (selection.density) {
        const auto values = densities(*here.points);
        both(all, [&](std::size_t i) {
            return sure(values[i] >= selection.density->min && values[i] <= selection.density->max);
        });
    }
    if (selection.polygon) {
        const auto x = plainQuantity(selection.polygon->first, run, step);
        const auto y = plainQuantity(selection.polygon->second, run, step);
        both(all, [&](std::size_t i) { return sure(plainInside(selection.polygon->points, x[i], y[i])); });
    }
    if (selection.lasso) {
        const auto& lasso = *selection.lasso;
        const auto where = lasso.plot.empty() ? places(*here.points) : placesBy(lasso.plot, run, step);
        both(all, [&](std::size_t i) {
            return std::isnan(where[i].x + where[i].y + where[i].z) ? Chosen::no : inLasso(lasso, where[i]);
        });
    }
    if (selection.outermost) {
        const auto found = outermost(*selection.outermost, run, step);
        both(all, [&](std::size_t i) { return found[i]; });
    }
    if (!selection.ids.empty()) {
        const auto own = here.columns->ids(0, all.size());
        both(all, [&](std::size_t i) {
            return sure(std::find(selection.ids.begin(), selection.ids.end(), own[i]) != selection.ids.end());
        });
    }
    for (const auto& inner : selection.all) {
        const auto found = plainSelection(inner, run, step);
        both(all, [&](std::size_t i) { return found[i]; });
    }
    if (!selection.any.empty()) {
        All any(all.size(), Chosen::no);
        for (const auto& inner : selection.any) {
            const auto found = plainSelection(inner, run, step);
            for (std::size_t i = 0; i < any.size(); ++i) any[i] = std::max(any[i], found[i]);
        }
        both(all, [&](std::size_t i) { return any[i]; });
    }
    for (const auto& inner : selection.negated) {
        const auto found = plainSelection(inner, run, step);
        both(all, [&](std::size_t i) { return opposite(found[i]); });
    }
    return all;
}

}  // namespace mote::test
