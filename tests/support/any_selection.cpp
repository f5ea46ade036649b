// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/any_selection.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace mote::test {
namespace {

using Column = SelectionShape::Column;

const Column& anyColumn(Random& random, const SelectionShape& shape) {
    return shape.columns[random.below(shape.columns.size())];
}

Selection::Range anyRange(Random& random, const Column& column) {
    Selection::Range range{column.name};
    const double a = random.between(column.low, column.high), b = random.between(column.low, column.high);
    if (random.chance(0.7)) range.min = std::min(a, b);
    if (random.chance(0.7)) range.max = std::max(a, b);
    return range;
}

Selection::Polygon anyPolygonOf(Random& random, const SelectionShape& shape) {
    const auto& first = anyColumn(random, shape);
    const auto* second = &anyColumn(random, shape);
    while (second->name == first.name) second = &anyColumn(random, shape);
    return {first.name, second->name,
            anyPolygon(random, {first.low, second->low}, {first.high, second->high}, shape.mostPoints)};
}

/// A plot of other axes, which shows most of each column, and more or less than all of it.
std::vector<Selection::PlotAxis> anyPlot(Random& random, const SelectionShape& shape) {
    std::vector<Selection::PlotAxis> plot;
    for (int axis = 0; axis < 3; ++axis) {
        const auto& column = anyColumn(random, shape);
        const double margin = random.between(-0.2, 0.2) * (column.high - column.low);
        plot.push_back({column.name, column.low - margin, column.high + margin});
    }
    return plot;
}

Selection::Lasso anyLasso(Random& random, const SelectionShape& shape) {
    Selection::Lasso lasso;
    lasso.camera.eye = random.between(0.5, 5.0) * random.direction();
    lasso.camera.target = 0.3 * random.direction();
    lasso.camera.up = random.direction();
    lasso.camera.fovYDegrees = random.between(10.0, 90.0);
    if (random.chance(0.3)) lasso.camera.orthographicHeight = random.between(0.5, 3.0);
    lasso.aspect = random.between(0.5, 2.0);
    if (random.chance(0.4)) {
        for (int i = 0; i < 3; ++i) lasso.transform[i][i] = random.between(0.5, 2.0);
        for (int i = 0; i < 3; ++i) lasso.transform[3][i] = random.between(-0.5, 0.5);
    }
    lasso.points = anyPolygon(random, {-0.2, -0.2}, {1.2, 1.2}, shape.mostPoints);
    // Of a layer that is cut. By numbers of its own: all else stays as it would be.
    Random own(static_cast<std::uint64_t>(1e9 * std::abs(lasso.camera.eye.x)), 11);
    if (shape.columns.size() > 1 && own.chance(0.3)) lasso.plot = anyPlot(own, shape);
    if (!own.chance(0.3)) return lasso;
    proto::Clip clip;
    auto& plane = *clip.add_planes();
    const glm::dvec3 normal = own.direction();
    for (int i = 0; i < 3; ++i) plane.add_normal(normal[i]);
    plane.set_distance(own.between(-0.5, 0.5));
    lasso.clip = parseClip(std::move(clip)).value();
    return lasso;
}

Selection::Density anyDensity(Random& random) {
    const double a = random.unit(), b = random.unit();
    Selection::Density density;
    if (random.chance(0.6)) density.min = std::min(a, b);
    if (random.chance(0.6)) density.max = std::max(a, b);
    return density;
}

std::vector<std::uint64_t> anyIds(Random& random, std::uint64_t ids) {
    std::vector<std::uint64_t> some;
    const auto count = random.chance(0.5) ? 1 + random.below(10) : 1 + random.below(ids);
    for (std::uint64_t i = 0; i < count; ++i) some.push_back(random.below(ids));
    std::sort(some.begin(), some.end());
    some.erase(std::unique(some.begin(), some.end()), some.end());
    return some;
}

/// One condition of the node's own.
void addCondition(Random& random, const SelectionShape& shape, Selection& selection) {
    const auto kind = random.below(7);
    if (kind < 2 && !shape.columns.empty())
        selection.ranges.push_back(anyRange(random, anyColumn(random, shape)));
    if (kind == 2 && shape.density) selection.density = anyDensity(random);
    if (kind == 3 && shape.columns.size() > 1) selection.polygon = anyPolygonOf(random, shape);
    if (kind == 4 && shape.lasso) selection.lasso = anyLasso(random, shape);
    if (kind == 5 && !shape.planes.empty())
        selection.outermost = {shape.planes[random.below(shape.planes.size())],
                               random.chance(0.1) ? 1.0 : random.unit()};
    if (kind == 6 && shape.ids > 0) selection.ids = anyIds(random, shape.ids);
}

}  // namespace

std::vector<glm::dvec2> anyPolygon(Random& random, glm::dvec2 low, glm::dvec2 high, std::uint64_t most) {
    const auto count = 3 + random.below(most - 2);
    const bool star = random.chance(0.5), coarse = random.chance(0.4);
    std::vector<glm::dvec2> points;
    for (std::uint64_t i = 0; i < count; ++i) {
        const double angle = glm::two_pi<double>() * static_cast<double>(i) / static_cast<double>(count);
        const double far = random.between(0.1, 0.5);
        glm::dvec2 place = star ? glm::dvec2(0.5) + far * glm::dvec2(std::cos(angle), std::sin(angle))
                                : glm::dvec2(random.unit(), random.unit());
        if (coarse) place = glm::round(4.0 * place) / 4.0;
        points.push_back(low + place * (high - low));
    }
    return points;
}

Selection anySelection(Random& random, const SelectionShape& shape) {
    Selection selection;
    for (auto count = random.below(3); count > 0; --count) addCondition(random, shape, selection);
    if (shape.steps > 0 && random.chance(0.15))
        selection.step = static_cast<std::uint32_t>(random.below(shape.steps));
    if (shape.nothing) selection.nothing = random.chance(0.1);
    if (shape.depth <= 1) return selection;
    SelectionShape inner = shape;
    --inner.depth;
    const auto some = [&](double share, std::uint64_t most) {
        std::vector<Selection> list;
        if (random.chance(share)) {
            for (auto count = 1 + random.below(most); count > 0; --count)
                list.push_back(anySelection(random, inner));
        }
        return list;
    };
    selection.all = some(0.2, 2);
    selection.any = some(0.3, 3);
    selection.negated = some(0.25, 1);
    return selection;
}

}  // namespace mote::test
