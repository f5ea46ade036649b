// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_request_check.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "protocol/scene/job_request.h"

namespace mote::server {
namespace {

/// An error about a path, told of the field that holds it.
Error ofField(const std::string& field, const Error& error) {
    return {error.code, field, error.toString()};
}

}  // namespace

Result<JobOutput> findOutput(const proto::JobRequest& request, const storage::Roots& roots) {
    const auto& name = request.output();
    JobOutput output;
    auto path = roots.resolveNew(name);
    if (!path.ok() && path.error().code == ErrorCode::alreadyExists) {
        output.exists = true;
        path = roots.resolveExisting(name);
    }
    if (!path.ok()) return path.error();
    output.path = *std::move(path);
    for (const auto& entry : roots.entries()) {
        if (name.starts_with(entry.name + "/")) output.root = entry.folder;
    }
    return output;
}

Result<JobOutput> checkJobRequest(const proto::JobRequest& message, const storage::Roots& roots) {
    MOTE_ASSIGN_OR_RETURN(const auto request, parseJobRequest(message));
    for (const auto& input : request.inputs) {
        const auto path = roots.resolveExisting(input.name);
        if (!path.ok()) return ofField(input.field, path.error());
    }
    if (staysWithJob(message)) return JobOutput{};
    auto output = findOutput(message, roots);
    if (!output.ok()) return ofField("output", output.error());
    if (output->exists) {
        return Error{ErrorCode::alreadyExists, "output", fmt::format("{} exists already", message.output())};
    }
    return output;
}

}  // namespace mote::server
