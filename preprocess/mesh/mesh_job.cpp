// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/mesh_job.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "preprocess/kept_notes.h"
#include "preprocess/mesh/find_intersections.h"
#include "preprocess/mesh/isosurface.h"
#include "preprocess/mesh/read_mesh.h"
#include "preprocess/mesh/surface_topology.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "preprocess/new_dataset.h"
#include "preprocess/world_unit.h"
#include "storage/mesh/mesh_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// Where a surface lies.
struct SurfaceWorld {
    std::string space;  ///< in which patients lie, of their surfaces
    std::string unit;   ///< of a length; "": not known
};

proto::Manifest describe(const proto::JobRequest& request, const fs::path& input, const fs::path& output,
                         const storage::SurfaceMesh& mesh, const SurfaceWorld& world) {
    auto manifest = beginManifest("mesh", request, input.filename().string());
    manifest.mutable_request()->mutable_mesh()->set_input(portableInput(input, output));
    *manifest.mutable_mesh() = storage::describeMesh(mesh);
    manifest.set_world_unit(world.unit);
    if (!world.space.empty() && manifest.up().empty()) {
        // A patient's surface stands as the patient does.
        manifest.set_up("z");
        manifest.set_front(world.space == "ras" ? "y" : "-y");
    }
    return manifest;
}

/// What the job takes of memory for each triangle of an isosurface, its topology included.
constexpr std::uint64_t bytesPerTriangle = 256;
/// And for each sample of a slice, of which two are held, with what is known of their cells.
constexpr std::uint64_t bytesPerSample = 18;

Result<TriangleMesh> readSurface(const proto::JobRequest& request, const fs::path& input,
                                 std::uint64_t memory, Progress& progress, SurfaceWorld& world) {
    const auto& job = request.mesh();
    MeshCounts counts;
    world.unit = request.unit();
    if (!job.has_isovalue()) {
        MOTE_ASSIGN_OR_RETURN(auto read, readMesh(input, meshFileLimit(memory), progress));
        if (const auto repairs = describeRepairs(read.counts); !repairs.empty()) progress.note(repairs);
        return std::move(read.mesh);
    }
    MOTE_ASSIGN_OR_RETURN(const auto source, openVolumeSource(job.source(), input, progress));
    world.space = source->shape().worldSpace;
    MOTE_ASSIGN_OR_RETURN(world.unit, worldUnitFor(request, source->shape(), progress));
    const auto slices = source->shape().voxelsOfSlice() * bytesPerSample;
    if (slices > memory) {
        return Error{
            ErrorCode::resourceExhausted, "isovalue",
            fmt::format("two slices of the volume take {} MB, more than the job may", slices >> 20U)};
    }
    IsosurfaceOptions options{.value = job.isovalue(), .mostTriangles = memory / bytesPerTriangle};
    const auto& clip = job.clip();
    if (!clip.empty()) options.clip = Bounds{{clip[0], clip[1], clip[2]}, {clip[3], clip[4], clip[5]}};
    MOTE_ASSIGN_OR_RETURN(auto surface, isosurface(*source, options, progress));
    if (const auto origin = describeOrigin(surface.origin); !origin.empty()) progress.note(origin);
    auto welded = weldMesh(std::move(surface), counts);
    if (!welded.triangles.empty()) return welded;
    return invalid("isovalue", "its surface has no area");
}

void addIntersections(storage::SurfaceMesh& mesh, Progress& progress) {
    progress.report(0.6, "finding where triangles cut each other");
    auto pairs = findIntersections(mesh, [&] { return progress.cancelled(); });
    if (pairs)
        mesh.intersections = *std::move(pairs);
    else if (!progress.cancelled())
        progress.note("its triangles cut each other in so many places that no lines are drawn there");
}

}  // namespace

std::uint64_t meshFileLimit(std::uint64_t memory) {
    return memory / 18;
}

Result<proto::Manifest> runMeshJob(const proto::JobRequest& request, const fs::path& input,
                                   const fs::path& output, const JobResources& resources, Progress& told) {
    KeptNotes progress(told);
    MOTE_ASSIGN_OR_RETURN(auto writer, storage::DatasetWriter::create(output));
    progress.report(0.0, "reading");
    SurfaceWorld world;
    MOTE_ASSIGN_OR_RETURN(const auto surface,
                          readSurface(request, input, memoryFor(resources.memory), progress, world));
    progress.report(0.5, "finding edges and normals");
    auto mesh = makeSurfaceMesh(surface);
    // The surface of a value does not cut itself.
    if (!request.mesh().has_isovalue()) addIntersections(mesh, progress);
    if (progress.cancelled()) return wasCancelled();
    progress.report(0.8, "writing");
    MOTE_RETURN_IF_ERROR(storage::writeMesh(writer.directory(), mesh));
    auto manifest = describe(request, input, output, mesh, world);
    manifest.mutable_mesh()->mutable_notes()->Assign(progress.notes().begin(), progress.notes().end());
    return finishDataset(writer, {"mesh"}, std::move(manifest), progress);
}

}  // namespace mote::prep
