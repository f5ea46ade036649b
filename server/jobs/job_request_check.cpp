// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_request_check.h"

#include <fmt/format.h>

#include "protocol/scene/job_request.h"

namespace mote::server {
namespace {

/// An error about a path, told of the field that holds it.
Error ofField(const std::string& field, const Error& error) {
    return {error.code, field, error.toString()};
}

}  // namespace

Result<JobOutput> checkJobRequest(const proto::JobRequest& message, const storage::Roots& roots) {
    MOTE_ASSIGN_OR_RETURN(const auto request, parseJobRequest(message));
    for (const auto& input : request.inputs) {
        const auto path = roots.resolveExisting(input.name);
        if (!path.ok()) return ofField(input.field, path.error());
    }
    auto output = findOutput(message, roots);
    if (!output.ok()) return ofField("output", output.error());
    if (output->exists) {
        return Error{ErrorCode::alreadyExists, "output", fmt::format("{} exists already", message.output())};
    }
    return output;
}

}  // namespace mote::server
