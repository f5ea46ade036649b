// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/stipple_job.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "preprocess/machine_memory.h"
#include "preprocess/on_threads.h"
#include "preprocess/stipple/plane_start.h"
#include "storage/dataset_writer.h"
#include "storage/manifest.h"
#include "storage/stipple/hierarchy_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr double mostRelaxation = 1.9;
/// Measured: 1230 at 400,000 points, the program itself included; rounded up.
constexpr std::uint64_t planeBytesPerPoint = 1500;
/// The share of a plane job's time that the start takes.
constexpr double startShare = 0.3;

Error invalid(std::string field, std::string message) {
    return {ErrorCode::invalidArgument, std::move(field), std::move(message)};
}

Result<storage::StippleHierarchy> buildPlane(const proto::StippleJob& job, Progress& progress) {
    const auto points = static_cast<std::uint32_t>(job.points());
    MOTE_ASSIGN_OR_RETURN(const auto start, evenPoints(points, job.seed(), startShare, progress));
    return thinPlane(start, thinningOptions(job), startShare, progress);
}

Result<storage::StippleHierarchy> buildPlaneOn(int threads, const proto::StippleJob& job,
                                               Progress& progress) {
    return onThreads(threads, [&] { return buildPlane(job, progress); });
}

}  // namespace

Status checkStippleJob(const proto::StippleJob& job) {
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (job.points() < 1 || job.points() > most) {
        return invalid("points", fmt::format("must be 1 to {}, not {}", most, job.points()));
    }
    if (job.has_rings() && (job.rings() < 1 || job.rings() > 2)) {
        return invalid("rings", fmt::format("must be 1 or 2, not {}", job.rings()));
    }
    const double relaxation = thinningOptions(job).relaxation;
    if (!(relaxation >= 1.0 && relaxation <= mostRelaxation)) {
        return invalid("relaxation", fmt::format("must be 1 to {}", mostRelaxation));
    }
    return success();
}

ThinningOptions thinningOptions(const proto::StippleJob& job) {
    ThinningOptions options;
    if (job.has_rings()) options.rings = static_cast<int>(job.rings());
    if (job.has_relaxation()) options.relaxation = job.relaxation();
    return options;
}

Status checkStippleMemory(const proto::StippleJob& job, std::uint64_t bytesPerPoint,
                          const JobResources& resources) {
    const auto needed = job.points() * bytesPerPoint;
    const auto memory = memoryFor(resources.memory);
    if (needed <= memory) return success();
    return Error{ErrorCode::resourceExhausted, "points",
                 fmt::format("{} points need {} MiB of memory where the job may take {} MiB", job.points(),
                             needed >> 20, memory >> 20)};
}

proto::Manifest describeHierarchy(const proto::JobRequest& request,
                                  const storage::StippleHierarchy& hierarchy,
                                  proto::StippleManifest::Domain domain, double area) {
    const auto options = thinningOptions(request.stipple());
    proto::Manifest manifest;
    manifest.set_kind("stipple");
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    *manifest.mutable_request() = request;
    manifest.mutable_request()->clear_output();
    manifest.mutable_request()->mutable_stipple()->clear_mesh();
    manifest.set_title(request.title());
    auto& stipple = *manifest.mutable_stipple();
    stipple.set_domain(domain);
    stipple.set_points(hierarchy.size());
    stipple.set_moves(hierarchy.moveNeighbour.size());
    stipple.set_locked(std::accumulate(hierarchy.locked.begin(), hierarchy.locked.end(), std::uint64_t{0}));
    stipple.set_area(area);
    stipple.set_rings(static_cast<std::uint32_t>(options.rings));
    stipple.set_relaxation(options.relaxation);
    stipple.set_seed(request.stipple().seed());
    return manifest;
}

Result<proto::Manifest> runPlaneJob(const proto::JobRequest& request, const fs::path& output,
                                    const JobResources& resources, Progress& progress) {
    const auto& job = request.stipple();
    MOTE_RETURN_IF_ERROR(checkStippleJob(job));
    MOTE_RETURN_IF_ERROR(checkStippleMemory(job, planeBytesPerPoint, resources));
    // Before the work: a place that cannot be had is said at once.
    MOTE_ASSIGN_OR_RETURN(auto writer, storage::DatasetWriter::create(output));
    MOTE_ASSIGN_OR_RETURN(const auto hierarchy, buildPlaneOn(resources.threads, job, progress));
    MOTE_RETURN_IF_ERROR(storage::writeHierarchy(writer.directory(), hierarchy));
    for (const auto* file : {"hierarchy.h5", "hierarchy.digest"}) {
        MOTE_RETURN_IF_ERROR(writer.add(file, [&] { return progress.cancelled(); }));
    }
    auto manifest = describeHierarchy(request, hierarchy, proto::StippleManifest::PLANE, 1.0);
    if (manifest.title().empty()) manifest.set_title(fmt::format("plane of {} points", hierarchy.size()));
    MOTE_RETURN_IF_ERROR(writer.publish(manifest));
    manifest.mutable_files()->Assign(writer.files().begin(), writer.files().end());
    return manifest;
}

}  // namespace mote::prep
