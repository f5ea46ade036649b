// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/surface_job.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/read_mesh.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "preprocess/new_dataset.h"
#include "preprocess/on_threads.h"
#include "preprocess/stipple/surface/surface_thinning.h"
#include "preprocess/synth/philox.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::prep {
namespace {

constexpr int steps = 40;
constexpr double startRelaxation = 1.6;
/// Where the mean way is shorter, in spacings, there is nothing left to gain.
constexpr double settled = 2e-3;

SurfacePoint pointIn(const WalkMesh& mesh, std::uint32_t triangle, double u, double v) {
    // Even over the triangle: sqrt(u) is the share of the way from the first corner to the opposite side.
    const double root = std::sqrt(u);
    const auto a = mesh.corner(triangle, 0);
    return {a + root * ((1.0 - v) * (mesh.corner(triangle, 1) - a) + v * (mesh.corner(triangle, 2) - a)),
            triangle};
}

namespace fs = std::filesystem;

/// The share of the job's time that the start takes.
constexpr double startShare = 0.3;
/// Measured: 735 a point from 200,000 to 10^6 points; rounded up.
constexpr std::uint64_t surfaceBytesPerPoint = 900;

Result<storage::StippleHierarchy> build(const WalkMesh& mesh, const proto::StippleJob& job,
                                        Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto start, evenSurfacePoints(mesh, static_cast<std::uint32_t>(job.points()),
                                                        job.seed(), startShare, progress));
    return thinSurface(mesh, std::move(start), thinningOptions(job), startShare, progress);
}

Result<storage::StippleHierarchy> buildOn(int threads, const WalkMesh& mesh, const proto::StippleJob& job,
                                          Progress& progress) {
    return onThreads(threads, [&] { return build(mesh, job, progress); });
}

proto::Manifest describe(const proto::JobRequest& request, const fs::path& input, const fs::path& output,
                         const storage::SurfaceMesh& mesh, const storage::StippleHierarchy& hierarchy) {
    const auto described = storage::describeMesh(mesh);
    auto manifest =
        describeHierarchy(request, hierarchy, proto::StippleManifest::SURFACE, described.area(),
                          fmt::format("{}: {} points", input.filename().string(), hierarchy.size()));
    manifest.mutable_request()->mutable_stipple()->set_mesh(portableInput(input, output));
    *manifest.mutable_mesh() = described;
    manifest.set_world_unit(request.unit());
    return manifest;
}

}  // namespace

double hexagonalSpacing(double area, std::size_t points) {
    return std::sqrt(2.0 / std::sqrt(3.0) * area / static_cast<double>(std::max<std::size_t>(points, 1)));
}

void refill(PointSet& set, const WalkMesh& mesh, const std::vector<bool>& within, std::size_t count) {
    set.spacing = hexagonalSpacing(mesh.area(), count);
    set.grid = PointGrid(set.points.size(), count, 1.5 * set.spacing);
    for (std::uint32_t i = 0; i < set.points.size(); ++i) {
        if (within[i]) set.grid.add(i, set.points[i].position);
    }
}

PointSet scatterPoints(const WalkMesh& mesh, std::uint32_t points, std::uint64_t seed) {
    PointSet set{{}, {}, PointGrid(0, 0, 1.0), 0.0};
    set.points.reserve(points);
    set.normals.reserve(points);
    const auto last = static_cast<std::uint32_t>(mesh.triangles() - 1);
    std::uint32_t triangle = 0;
    double end = mesh.area(0);  // of the area up to this triangle
    for (std::uint32_t i = 0; i < points; ++i) {
        ParticleRandom random(seed, i);
        const double at = (i + random.next()) / points * mesh.area();
        while (at >= end && triangle < last) end += mesh.area(++triangle);
        const double u = random.next();
        set.points.push_back(pointIn(mesh, triangle, u, random.next()));
        set.normals.emplace_back(mesh.normalAt(set.points.back()));
    }
    refill(set, mesh, std::vector<bool>(points, true), points);
    return set;
}

double relaxOnce(const WalkMesh& mesh, PointSet& set, double relaxation) {
    const SurfaceCells cells(mesh, set);
    tbb::enumerable_thread_specific<CellScratch> scratches(
        [&] { return CellScratch(mesh.triangles(), set.points.size()); });
    auto moved = set.points;
    std::vector<float> ways(moved.size());
    const double longest = 0.5 * set.spacing;
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(moved.size()), 256),
                      [&](const auto& range) {
                          auto& scratch = scratches.local();
                          SurfaceCell cell;
                          for (auto i = range.begin(); i < range.end(); ++i) {
                              cells.find(i, SurfaceCells::none, scratch, cell);
                              // Where the surface turns out of sight, the cell says at least which way is
                              // free.
                              auto way = relaxation * cell.toCentroid;
                              const double length = glm::length(way);
                              if (length > longest) way *= longest / length;
                              ways[i] = static_cast<float>(std::min(length, longest));
                              moved[i] = mesh.walk(set.points[i], way);
                          }
                      });
    double sum = 0.0;
    for (std::uint32_t i = 0; i < moved.size(); ++i) {
        sum += ways[i];
        set.grid.move(i, set.points[i].position, moved[i].position);
    }
    set.points = std::move(moved);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, set.points.size(), 1024), [&](const auto& range) {
        for (auto i = range.begin(); i < range.end(); ++i) {
            set.normals[i] = glm::vec3(mesh.normalAt(set.points[i]));
        }
    });
    return sum / static_cast<double>(set.points.size()) / set.spacing;
}

Result<PointSet> evenSurfacePoints(const WalkMesh& mesh, std::uint32_t points, std::uint64_t seed,
                                   double share, Progress& progress) {
    auto set = scatterPoints(mesh, points, seed);
    for (int step = 0; step < steps; ++step) {
        if (progress.cancelled()) return wasCancelled();
        progress.report(share * step / steps, "spreading the points");
        if (relaxOnce(mesh, set, startRelaxation) < settled) break;
    }
    return set;
}

Result<proto::Manifest> runSurfaceJob(const proto::JobRequest& request, const fs::path& input,
                                      const fs::path& output, const JobResources& resources,
                                      Progress& progress) {
    const auto& job = request.stipple();
    MOTE_RETURN_IF_ERROR(checkStippleJob(job));
    MOTE_RETURN_IF_ERROR(checkStippleMemory(job, surfaceBytesPerPoint, resources));
    // Before the work: a place that cannot be had is said at once.
    MOTE_ASSIGN_OR_RETURN(auto writer, storage::DatasetWriter::create(output));
    progress.report(0.0, "reading the mesh");
    MOTE_ASSIGN_OR_RETURN(auto read, readMesh(input, meshFileLimit(memoryFor(resources.memory)), progress));
    if (const auto repairs = describeRepairs(read.counts); !repairs.empty()) progress.note(repairs);
    orderInSpace(read.mesh);  // the points take over its order
    const auto mesh = makeSurfaceMesh(read.mesh);
    const WalkMesh walk(mesh, findNeighbours(read.mesh.triangles));
    MOTE_ASSIGN_OR_RETURN(const auto hierarchy, buildOn(resources.threads, walk, job, progress));
    MOTE_RETURN_IF_ERROR(storage::writeMesh(writer.directory(), mesh));
    MOTE_RETURN_IF_ERROR(storage::writeHierarchy(writer.directory(), hierarchy));
    return finishDataset(writer, {"mesh", "hierarchy"}, describe(request, input, output, mesh, hierarchy),
                         progress);
}

}  // namespace mote::prep
