// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/surface_measures.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "preprocess/stipple/surface/surface_job.h"

namespace mote::test {

struct NearestTriangle::Scene {
    explicit Scene(const storage::SurfaceMesh& from)
        : mesh(from), device(rtcNewDevice(nullptr)), scene(rtcNewScene(device)) {
        const auto geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        // Embree reads 16 bytes at each vertex.
        auto* const vertices = static_cast<glm::vec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                    mesh.positions.size()));
        std::copy(mesh.positions.begin(), mesh.positions.end(), vertices);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh.triangles.data(), 0, sizeof(mesh.triangles[0]),
                                   mesh.triangles.size());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
    }
    ~Scene() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    glm::dvec3 corner(std::uint32_t triangle, std::size_t corner) const {
        return glm::dvec3(mesh.positions[mesh.triangles[triangle][corner]]);
    }

    const storage::SurfaceMesh& mesh;
    RTCDevice device;
    RTCScene scene;
};

namespace {

struct Search {
    const storage::SurfaceMesh& mesh;
    glm::dvec3 place;
    NearestTriangle::Found found;
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    const auto& triangle = search.mesh.triangles[arguments->primID];
    const auto corner = [&](std::size_t i) { return glm::dvec3(search.mesh.positions[triangle[i]]); };
    const auto nearest = nearestOnTriangle(search.place, corner(0), corner(1), corner(2));
    const double distance = glm::distance(nearest, search.place);
    if (distance >= search.found.distance) return false;
    search.found = {arguments->primID, nearest, distance};
    arguments->query->radius = static_cast<float>(distance) * 1.0001F;
    return true;
}

}  // namespace

NearestTriangle::NearestTriangle(const storage::SurfaceMesh& mesh) : scene_(std::make_unique<Scene>(mesh)) {}
NearestTriangle::NearestTriangle(NearestTriangle&&) noexcept = default;
NearestTriangle::~NearestTriangle() = default;

NearestTriangle::Found NearestTriangle::find(const glm::vec3& place) const {
    Search search{scene_->mesh, glm::dvec3(place), {}};
    search.found.distance = std::numeric_limits<double>::infinity();
    RTCPointQuery query{};
    query.x = place.x;
    query.y = place.y;
    query.z = place.z;
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_->scene, &query, &context, visit, &search);
    return search.found;
}

glm::dvec3 nearestOnTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                             const glm::dvec3& c) {
    const auto ab = b - a;
    const auto ac = c - a;
    const auto ap = p - a;
    const double d1 = glm::dot(ab, ap);
    const double d2 = glm::dot(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) return a;
    const auto bp = p - b;
    const double d3 = glm::dot(ab, bp);
    const double d4 = glm::dot(ac, bp);
    if (d3 >= 0.0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
    const auto cp = p - c;
    const double d5 = glm::dot(ab, cp);
    const double d6 = glm::dot(ac, cp);
    if (d6 >= 0.0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    const double scale = 1.0 / (va + vb + vc);
    return a + vb * scale * ab + vc * scale * ac;
}

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
