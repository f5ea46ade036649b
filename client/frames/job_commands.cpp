// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/job_commands.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "client/frames/print_line.h"
#include "client/frames/running_server.h"
#include "client/shared/job_percentage.h"
#include "client/shared/jobs.h"
#include "client/shared/server_jobs.h"
#include "protocol/scene/complain.h"
#include "protocol/scene/json.h"
#include "protocol/scene/utf8.h"

namespace mote::client {
namespace {

std::string jsonOf(const proto::JobStatus& job) {
    return toJsonLine(job, true) + "\n";
}

/// What is to be said of it beside its state.
const std::string& remark(const proto::JobStatus& job) {
    if (!isUnderWay(job)) return job.error();
    return job.waits_for().empty() ? job.phase() : job.waits_for();
}

std::string lineOf(const proto::JobStatus& job) {
    const auto line =
        fmt::format("{}  {:<9}  {:3.0f}%  {}{}{}", job.id(), stateName(job.state()), 100.0 * job.progress(),
                    jobName(job.request()), remark(job).empty() ? "" : ": ", remark(job));
    return toTerminalText(line) + "\n";
}

Status listJobs(ServerLine& server, bool json) {
    Status printed = success();
    MOTE_RETURN_IF_ERROR(eachJob(server, [&](const proto::JobStatus& job) {
        printed = print(json ? jsonOf(job) : lineOf(job));
        return printed.ok();
    }));
    return printed;
}

/// How it ended.
Result<proto::JobStatus> watchJob(ServerLine& server, const FramesOptions& options) {
    JobPercentage percentage("job", !options.quiet);
    return awaitJob(server, options.jobId, [&](const proto::JobStatus& job) -> Status {
        percentage.show(job);
        return options.json ? print(jsonOf(job)) : success();
    });
}

/// A job that failed shows the last lines of its log, unless they are in what was printed of it, or nobody
/// wants to read them.
Status followJob(ServerLine& server, const FramesOptions& options) {
    MOTE_ASSIGN_OR_RETURN(const auto job, watchJob(server, options));
    if (job.state() == proto::JobStatus::SUCCEEDED) return success();
    if (!options.json && !options.quiet) {
        for (const auto& line : job.log()) complain("mote-frames", line);
    }
    return Error{ErrorCode::internal, options.jobId,
                 job.error().empty() ? fmt::format("the job was {}", stateName(job.state())) : job.error()};
}

Status cancelJob(ServerLine& server, const std::string& id) {
    MOTE_RETURN_IF_ERROR(server.answerTo<proto::JobStatus>(
        [&](auto reply) { server.line().cancelJob(id, std::move(reply)); }));
    return success();
}

Status retryJob(ServerLine& server, const std::string& id) {
    MOTE_ASSIGN_OR_RETURN(const auto job, server.answerTo<proto::JobStatus>([&](auto reply) {
        server.line().retryJob(id, std::move(reply));
    }));
    return print(toTerminalText(job.id()) + "\n");
}

}  // namespace

Status runJobCommand(const FramesOptions& options, const Interrupt& interrupt) {
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, runningServer(options, wakeup, interrupt));
    if (options.task == FramesTask::listJobs) return listJobs(*server, options.json);
    if (options.task == FramesTask::follow) return followJob(*server, options);
    if (options.task == FramesTask::cancel) return cancelJob(*server, options.jobId);
    return retryJob(*server, options.jobId);
}

}  // namespace mote::client
