// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/run_job.h"

#include <fmt/format.h>

#include "preprocess/hybrid/volume_job.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/image/image_job.h"
#include "preprocess/mesh/mesh_job.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/surface/surface_job.h"

#ifdef MOTE_HAVE_SYNTH
#include "preprocess/synth/beam.h"
#endif

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// "FIELD (NAME): sentence", keeping what kind of error it is.
Error inField(const Error& error, std::string_view field) {
    return {error.code, error.where.empty() ? std::string(field) : fmt::format("{} ({})", field, error.where),
            error.message};
}

Result<fs::path> outputPath(const proto::JobRequest& request, const storage::Roots& roots) {
    if (request.output().empty()) return Error{ErrorCode::invalidArgument, "output", "is missing"};
    if (roots.empty()) return fs::path(request.output());
    auto path = roots.resolveNew(request.output());
    return path.ok() ? path : inField(path.error(), "output");
}

Result<fs::path> inputPath(const std::string& name, const storage::Roots& roots, std::string_view field) {
    if (name.empty()) return Error{ErrorCode::invalidArgument, std::string(field), "is missing"};
    if (roots.empty()) return fs::path(name);
    auto path = roots.resolveExisting(name);
    return path.ok() ? path : inField(path.error(), field);
}

Result<std::vector<fs::path>> inputPaths(const google::protobuf::RepeatedPtrField<std::string>& inputs,
                                         const storage::Roots& roots, std::string_view kind) {
    std::vector<fs::path> paths;
    for (int i = 0; i < inputs.size(); ++i) {
        auto path = inputPath(inputs.at(i), roots, fmt::format("{}.inputs[{}]", kind, i));
        if (!path.ok()) return path.error();
        paths.push_back(*std::move(path));
    }
    return paths;
}

Result<JobOutcome> runParticles(const proto::JobRequest& request, const storage::Roots& roots,
                                fs::path output, const ParticlesJobOptions& options, Progress& progress) {
    const auto checked = checkParticlesJob(request.particles());
    if (!checked.ok()) return checked.error().within("particles");
    const auto inputs = inputPaths(request.particles().inputs(), roots, "particles");
    if (!inputs.ok()) return inputs.error();
    auto manifest = runParticlesJob(request, *inputs, output, options, progress);
    if (!manifest.ok()) return manifest.error();
    return JobOutcome{std::move(output), *std::move(manifest)};
}

Result<JobOutcome> runImage(const proto::JobRequest& request, const storage::Roots& roots, fs::path output,
                            const ParticlesJobOptions& options, Progress& progress) {
    const auto input = inputPath(request.image().input(), roots, "image.input");
    if (!input.ok()) return input.error();
    auto manifest = runImageJob(request, *input, output, options.memory, progress);
    if (!manifest.ok()) return manifest.error();
    return JobOutcome{std::move(output), *std::move(manifest)};
}

Result<JobOutcome> runMesh(const proto::JobRequest& request, const storage::Roots& roots, fs::path output,
                           const ParticlesJobOptions& options, Progress& progress) {
    const auto input = inputPath(request.mesh().input(), roots, "mesh.input");
    if (!input.ok()) return input.error();
    auto manifest = runMeshJob(request, *input, output, options.memory, progress);
    if (!manifest.ok()) return manifest.error();
    return JobOutcome{std::move(output), *std::move(manifest)};
}

Result<JobOutcome> runVolume(const proto::JobRequest& request, const storage::Roots& roots, fs::path output,
                             const ParticlesJobOptions& options, Progress& progress) {
    const auto checked = checkVolumeJob(request.volume());
    if (!checked.ok()) return checked.error().within("volume");
    const auto inputs = inputPaths(request.volume().inputs(), roots, "volume");
    if (!inputs.ok()) return inputs.error();
    auto manifest =
        runVolumeJob(request, *inputs, output, {options.threads, options.memory, options.ranks}, progress);
    if (!manifest.ok()) return manifest.error();
    return JobOutcome{std::move(output), *std::move(manifest)};
}

Result<JobOutcome> runStipple(const proto::JobRequest& request, const storage::Roots& roots, fs::path output,
                              const ParticlesJobOptions& options, Progress& progress) {
    const auto checked = checkStippleJob(request.stipple());
    if (!checked.ok()) return checked.error().within("stipple");
    const StippleJobOptions resources{options.threads, options.memory};
    if (request.stipple().mesh().empty()) {
        auto manifest = runPlaneJob(request, output, resources, progress);
        if (!manifest.ok()) return manifest.error();
        return JobOutcome{std::move(output), *std::move(manifest)};
    }
    const auto input = inputPath(request.stipple().mesh(), roots, "stipple.mesh");
    if (!input.ok()) return input.error();
    auto manifest = runSurfaceJob(request, *input, output, resources, progress);
    if (!manifest.ok()) return manifest.error();
    return JobOutcome{std::move(output), *std::move(manifest)};
}

}  // namespace

Result<JobOutcome> runJob(const proto::JobRequest& request, const storage::Roots& roots,
                          const ParticlesJobOptions& options, Progress& progress) {
    auto output = outputPath(request, roots);
    if (!output.ok()) return output.error();
    const bool together = options.ranks && options.ranks->size() > 1;
    const auto kind = request.kind_case();
    if (together && kind != proto::JobRequest::kParticles && kind != proto::JobRequest::kVolume) {
        return Error{ErrorCode::unsupported, "", "this kind of job runs in one process, not under MPI"};
    }
    switch (kind) {
        case proto::JobRequest::kParticles:
            return runParticles(request, roots, *std::move(output), options, progress);
        case proto::JobRequest::kImage:
            return runImage(request, roots, *std::move(output), options, progress);
        case proto::JobRequest::kMesh:
            return runMesh(request, roots, *std::move(output), options, progress);
        case proto::JobRequest::kVolume:
            return runVolume(request, roots, *std::move(output), options, progress);
        case proto::JobRequest::kStipple:
            return runStipple(request, roots, *std::move(output), options, progress);
#ifdef MOTE_HAVE_SYNTH
        case proto::JobRequest::kSynthBeam: {
            const auto made = synthesizeBeam(request.synth_beam(), *output, progress);
            if (!made.ok()) return made.error();
            return JobOutcome{*std::move(output), std::nullopt};
        }
#endif
        default:
            return Error{ErrorCode::invalidArgument, "", "the request holds no job that this program knows"};
    }
}

}  // namespace mote::prep
