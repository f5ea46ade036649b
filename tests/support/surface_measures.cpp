// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/surface_measures.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "preprocess/stipple/surface/surface_job.h"

namespace mote::test {

prep::PointSet placeOnSurface(const prep::WalkMesh& mesh, const NearestTriangle& nearest,
                              std::span<const glm::vec3> positions) {
    prep::PointSet set{{}, {}, prep::PointGrid(0, 0, 1.0), 0.0};
    set.points.resize(positions.size());
    set.normals.resize(positions.size());
    tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
        const auto found = nearest.find(positions[i]);
        set.points[i] = {found.position, found.triangle};
        set.normals[i] = glm::vec3(mesh.normalAt(set.points[i]));
    });
    prep::refill(set, mesh, std::vector<bool>(positions.size(), true), positions.size());
    return set;
}

SurfaceMeasures measureSurface(const prep::WalkMesh& mesh, const prep::PointSet& set) {
    const prep::SurfaceCells cells(mesh, set);
    tbb::enumerable_thread_specific<prep::CellScratch> scratches(
        [&] { return prep::CellScratch(mesh.triangles(), set.points.size()); });
    std::vector<prep::SurfaceCell> found(set.points.size());
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(found.size()), [&](std::uint32_t i) {
        cells.find(i, prep::SurfaceCells::none, scratches.local(), found[i]);
    });
    SurfaceMeasures measures;
    measures.points = set.points.size();
    std::vector<const prep::SurfaceCell*> flat;
    for (const auto& cell : found) {
        if (cell.flat) flat.push_back(&cell);
    }
    measures.flat = flat.size();
    if (flat.empty()) return measures;
    const auto count = static_cast<double>(flat.size());
    double areas = 0.0;
    for (const auto* cell : flat) areas += cell->area / count;
    measures.rho = std::numeric_limits<double>::infinity();
    double squares = 0.0;
    double paired = 0.0;
    for (const auto* cell : flat) {
        // A hexagon of area A has the moment 5 / (18 sqrt 3) A^2.
        measures.energy += cell->moment / (areas * areas) / (5.0 / (18.0 * std::sqrt(3.0))) / count;
        squares += (cell->area - areas) * (cell->area - areas) / count;
        measures.worstArea = std::max(measures.worstArea, cell->area / areas);
        if (cell->nearestPoint == prep::SurfaceCells::none || !found[cell->nearestPoint].flat) continue;
        measures.rho = std::min(measures.rho, cell->nearest / set.spacing);
        measures.nearest += cell->nearest / set.spacing;
        paired += 1.0;
    }
    measures.nearest /= std::max(paired, 1.0);
    measures.areaCv = std::sqrt(squares) / areas;
    return measures;
}

}  // namespace mote::test
