// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/export_particles.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <map>
#include <memory>

#include "client/shared/film_download.h"
#include "protocol/scene/utf8.h"

namespace mote::client {
namespace {

constexpr const char* wipe = "\r\x1b[K";

/// How far it is, on a terminal.
class Percentage {
  public:
    explicit Percentage(bool wanted) : visible_(wanted && ::isatty(STDERR_FILENO) == 1) {}
    ~Percentage() {
        if (visible_ && shown_) std::fputs(wipe, stderr);
    }
    Percentage(const Percentage&) = delete;
    Percentage& operator=(const Percentage&) = delete;

    void show(const proto::JobStatus& job) {
        if (!visible_) return;
        fmt::print(stderr, "{}export: {:.0f}% {}", wipe, 100.0 * job.progress(), toTerminalText(job.phase()));
        std::fflush(stderr);
        shown_ = true;
    }

  private:
    const bool visible_;
    bool shown_ = false;
};

bool hasEnded(const proto::JobStatus& job) {
    return job.state() == proto::JobStatus::SUCCEEDED || job.state() == proto::JobStatus::FAILED ||
           job.state() == proto::JobStatus::CANCELLED;
}

/// What the server tells of its jobs, by their ids. Shared with the line.
using KnownJobs = std::map<std::string, proto::JobStatus>;

/// Waits for the job's end. Errors: why it failed; cancelled: the job is then, too.
Result<proto::JobStatus> madeBy(ServerLine& server, const proto::JobStatus& submitted, KnownJobs& jobs,
                                bool quiet) {
    const auto& id = submitted.id();
    jobs.emplace(id, submitted);
    Percentage percentage(!quiet);
    const auto waited = server.waitUntil([&] {
        percentage.show(jobs[id]);
        return hasEnded(jobs[id]);
    });
    if (!waited.ok()) {
        server.line().cancelJob(id, {});
        server.farewell();
        return waited.error();
    }
    const auto& job = jobs[id];
    if (job.state() == proto::JobStatus::SUCCEEDED) return job;
    return Error{ErrorCode::internal, "", job.error().empty() ? "the export was cancelled" : job.error()};
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
    const auto jobs = std::make_shared<KnownJobs>();
    server.line().onJob([jobs](const proto::JobStatus& job) { (*jobs)[job.id()] = job; });
    MOTE_RETURN_IF_ERROR(
        server.answerTo<proto::Jobs>([&](auto reply) { server.line().watchJobs(std::move(reply)); }));
    MOTE_ASSIGN_OR_RETURN(const auto submitted, server.answerTo<proto::JobStatus>([&](auto reply) {
        server.line().submitJob(request, std::move(reply));
    }));
    MOTE_ASSIGN_OR_RETURN(const auto job, madeBy(server, submitted, *jobs, options.quiet));
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
