// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/surface_job.h"

#include <fmt/format.h>

#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/read_mesh.h"
#include "preprocess/mesh/spatial_order.h"
#include "preprocess/on_threads.h"
#include "preprocess/progress.h"
#include "preprocess/stipple/surface/surface_start.h"
#include "preprocess/stipple/surface/surface_thinning.h"
#include "storage/dataset_writer.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::prep {
namespace {

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

Status writeFiles(storage::DatasetWriter& writer, const storage::SurfaceMesh& mesh,
                  const storage::StippleHierarchy& hierarchy, Progress& progress) {
    MOTE_RETURN_IF_ERROR(storage::writeMesh(writer.directory(), mesh));
    MOTE_RETURN_IF_ERROR(storage::writeHierarchy(writer.directory(), hierarchy));
    for (const auto* file : {"mesh.h5", "mesh.digest", "hierarchy.h5", "hierarchy.digest"}) {
        MOTE_RETURN_IF_ERROR(writer.add(file, [&] { return progress.cancelled(); }));
    }
    return success();
}

proto::Manifest describe(const proto::JobRequest& request, const fs::path& input, const fs::path& output,
                         const storage::SurfaceMesh& mesh, const storage::StippleHierarchy& hierarchy) {
    const auto described = storage::describeMesh(mesh);
    auto manifest = describeHierarchy(request, hierarchy, proto::StippleManifest::SURFACE, described.area());
    manifest.mutable_request()->mutable_stipple()->set_mesh(portableInput(input, output));
    *manifest.mutable_mesh() = described;
    if (manifest.title().empty()) {
        manifest.set_title(fmt::format("{}: {} points", input.filename().string(), hierarchy.size()));
    }
    return manifest;
}

}  // namespace

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
    MOTE_RETURN_IF_ERROR(writeFiles(writer, mesh, hierarchy, progress));
    auto manifest = describe(request, input, output, mesh, hierarchy);
    MOTE_RETURN_IF_ERROR(writer.publish(manifest));
    manifest.mutable_files()->Assign(writer.files().begin(), writer.files().end());
    progress.report(1.0, "done");
    return manifest;
}

}  // namespace mote::prep
