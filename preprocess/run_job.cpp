// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/run_job.h"

#include <fmt/format.h>

#include <algorithm>

#include "preprocess/job_kinds.h"
#include "preprocess/parallel/communicator.h"
#include "protocol/scene/job_request.h"

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

Result<fs::path> inputPath(const JobInput& input, const storage::Roots& roots) {
    if (input.name.empty()) return Error{ErrorCode::invalidArgument, input.field, "is missing"};
    if (roots.empty()) return fs::path(input.name);
    auto path = roots.resolveExisting(input.name);
    return path.ok() ? path : inField(path.error(), input.field);
}

Result<std::vector<fs::path>> inputPaths(const proto::JobRequest& request, const storage::Roots& roots) {
    std::vector<fs::path> paths;
    for (const auto& input : jobInputs(request)) {
        MOTE_ASSIGN_OR_RETURN(auto path, inputPath(input, roots));
        paths.push_back(std::move(path));
    }
    return paths;
}

}  // namespace

Result<JobOutcome> runJob(const proto::JobRequest& request, const storage::Roots& roots,
                          const JobResources& resources, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto output, outputPath(request, roots));
    const auto found =
        std::ranges::find(jobKinds, request.kind_case(), [](const auto* kind) { return kind->kind; });
    if (found == jobKinds.end()) {
        return Error{ErrorCode::invalidArgument, "", "the request holds no job that this program knows"};
    }
    const auto& kind = **found;
    if (!kind.together && resources.ranks && resources.ranks->size() > 1) {
        return Error{ErrorCode::unsupported, "", "this kind of job runs in one process, not under MPI"};
    }
    MOTE_ASSIGN_OR_RETURN(const auto inputs, inputPaths(request, roots));
    MOTE_ASSIGN_OR_RETURN(auto manifest, kind.run({request, inputs, output, resources, progress}));
    return JobOutcome{std::move(output), std::move(manifest)};
}

}  // namespace mote::prep
