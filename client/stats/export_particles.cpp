// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/export_particles.h"

#include <string>
#include <utility>

#include "client/shared/film_download.h"
#include "client/shared/job_percentage.h"
#include "client/shared/server_jobs.h"

namespace mote::client {
namespace {

/// Waits for the job's end. Errors: why it failed, or is not waited for: the job is cancelled then.
Result<proto::JobStatus> madeBy(ServerLine& server, const std::string& id, bool quiet) {
    JobPercentage percentage("export", !quiet);
    auto job = awaitJob(server, id, [&](const proto::JobStatus& now) {
        percentage.show(now);
        return success();
    });
    if (!job.ok()) {
        server.line().cancelJob(id, {});
        server.farewell();
        return job;
    }
    if (job->state() == proto::JobStatus::SUCCEEDED) return job;
    return Error{ErrorCode::internal, "", job->error().empty() ? "the export was cancelled" : job->error()};
}

Status fetch(ServerLine& server, const proto::JobStatus& job, const std::filesystem::path& target) {
    MOTE_ASSIGN_OR_RETURN(const auto download, FilmDownload::begin(job, target));
    while (!download->done()) {
        const auto piece = server.answerTo<FilmBytes>(
            [&](auto reply) { server.line().fetchFilm(download->wanted(), std::move(reply)); });
        MOTE_RETURN_IF_ERROR(download->take(piece));
    }
    return success();
}

Status exportOpenPmd(const StatsOptions& options, AskedRun& run) {
    proto::JobRequest request;
    auto& asked = *request.mutable_export_();
    asked.set_dataset(run.dataset() + ".mote");
    asked.set_steps(run.stepsText());
    if (run.selection()) *asked.mutable_select() = *run.selection();
    asked.mutable_columns()->Assign(options.columns.begin(), options.columns.end());
    auto& server = run.server();
    MOTE_ASSIGN_OR_RETURN(const auto submitted, server.answerTo<proto::JobStatus>([&](auto reply) {
        server.line().submitJob(request, std::move(reply));
    }));
    MOTE_ASSIGN_OR_RETURN(const auto job, madeBy(server, submitted.id(), options.quiet));
    const auto fetched = fetch(server, job, options.exported);
    // The server need not keep it: a finished export that is cancelled is removed.
    server.line().cancelJob(job.id(), {});
    server.farewell();
    return fetched;
}

}  // namespace

Status exportParticles(const StatsOptions& options, AskedRun& run) {
    return options.exported.extension() == ".h5" ? exportOpenPmd(options, run) : exportRows(options, run);
}

}  // namespace mote::client
