// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/jobs.h"

#include <fmt/format.h>
#include <unistd.h>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "protocol/base/utf8.h"
#include "protocol/scene/film/check_script.h"

namespace mote::client {
namespace {

using Job = proto::JobStatus;

}  // namespace

proto::JobRequest filmRequest(const proto::Script& script, const std::string& video) {
    constexpr std::size_t longestName = 160;  // bytes; a title is no place for more
    const auto datasets = datasetsOf(script);
    auto of = datasets.empty() ? "nothing" : toUtf8(datasets.front().substr(0, longestName));
    if (datasets.size() > 1) of += fmt::format(" and {} more", datasets.size() - 1);
    proto::JobRequest request;
    request.set_title(
        fmt::format("{} of {}, {} frames", video.empty() ? "pictures" : video, of, frameCountOf(script)));
    *request.mutable_film()->mutable_script() = script;
    request.mutable_film()->set_video(video);
    return request;
}

std::string datasetName(const proto::JobRequest& request) {
    constexpr std::string_view suffix = ".mote";
    const auto& output = request.output();
    return output.ends_with(suffix) ? output.substr(0, output.size() - suffix.size()) : output;
}

std::string jobName(const proto::JobRequest& request) {
    if (!request.output().empty()) return datasetName(request);
    if (!request.title().empty()) return request.title();
    return request.has_film() ? "film" : request.has_export_() ? "export" : "job";
}

const char* stateName(Job::State state) {
    switch (state) {
        case Job::QUEUED:
            return "queued";
        case Job::RUNNING:
            return "running";
        case Job::SUCCEEDED:
            return "succeeded";
        case Job::FAILED:
            return "failed";
        case Job::CANCELLED:
            return "cancelled";
        default:
            return "unknown";
    }
}

bool isUnderWay(const Job& job) {
    return job.state() == Job::QUEUED || job.state() == Job::RUNNING;
}

bool hasEnded(const Job& job) {
    return job.state() == Job::SUCCEEDED || mayBeTriedAgain(job);
}

bool mayBeTriedAgain(const Job& job) {
    return job.state() == Job::FAILED || job.state() == Job::CANCELLED;
}

bool isReadyFilm(const Job& job) {
    // With a phase, it was thrown away since.
    return job.request().has_film() && job.state() == Job::SUCCEEDED && job.phase().empty();
}

namespace {

using Clock = std::chrono::steady_clock;

/// News of many jobs at once come as one list, which need not reach to the one that is waited for.
constexpr std::chrono::minutes lookAgainAfter{1};

/// What is heard of a job that is waited for.
struct News {
    std::optional<proto::JobStatus> latest;
    bool returned = false;  ///< the line broke meanwhile, and the server may not remember who watches
};

/// The listeners outlive the waiting.
std::shared_ptr<News> listenFor(const std::string& id, Connection& line) {
    auto news = std::make_shared<News>();
    line.onJob([news, id](const proto::JobStatus& job) {
        if (job.id() == id) news->latest = job;
    });
    line.onState(
        [news](Connection::State state) { news->returned |= state == Connection::State::connected; });
    return news;
}

/// Watches, and then looks how it stands: of a change in between the news is the newer word.
Status watch(ServerLine& server, const std::string& id, News& news) {
    news = {};
    MOTE_RETURN_IF_ERROR(
        server.answerTo<proto::Jobs>([&](auto reply) { server.line().watchJobs(std::move(reply)); }));
    MOTE_ASSIGN_OR_RETURN(auto job, findJob(server, id));
    if (!news.latest) news.latest = std::move(job);
    return success();
}

}  // namespace

Status eachJob(ServerLine& server, const std::function<bool(const proto::JobStatus&)>& take) {
    std::set<std::string> seen;  // a job that comes meanwhile moves others to the next page
    for (std::uint64_t first = 0;;) {
        MOTE_ASSIGN_OR_RETURN(const auto page, server.answerTo<proto::Jobs>([&](auto reply) {
            server.line().listJobs(first, std::move(reply));
        }));
        const auto before = seen.size();
        for (const auto& job : page.jobs()) {
            if (seen.insert(job.id()).second && !take(job)) return success();
        }
        if (seen.size() == before) return success();
        first += static_cast<std::uint64_t>(page.jobs_size());
    }
}

Result<proto::JobStatus> findJob(ServerLine& server, const std::string& id) {
    std::optional<proto::JobStatus> found;
    MOTE_RETURN_IF_ERROR(eachJob(server, [&](const proto::JobStatus& job) {
        if (job.id() == id) found = job;
        return !found;
    }));
    if (found) return *std::move(found);
    return Error{ErrorCode::notFound, "id", fmt::format("the server knows no job \"{}\"", id)};
}

Result<proto::JobStatus> awaitJob(ServerLine& server, const std::string& id,
                                  const std::function<Status(const proto::JobStatus&)>& show) {
    const auto news = listenFor(id, server.line());
    std::string shown;
    while (true) {
        MOTE_RETURN_IF_ERROR(watch(server, id, *news));
        const auto stale = Clock::now() + lookAgainAfter;
        Status said = success();
        MOTE_RETURN_IF_ERROR(server.waitUntil([&] {
            const auto present = news->latest->SerializeAsString();
            if (std::exchange(shown, present) != present) said = show(*news->latest);
            return !said.ok() || hasEnded(*news->latest) || news->returned || Clock::now() > stale;
        }));
        MOTE_RETURN_IF_ERROR(said);
        if (hasEnded(*news->latest)) return *news->latest;
    }
}

namespace {

constexpr const char* wipe = "\r\x1b[K";

}  // namespace

JobPercentage::JobPercentage(std::string what, bool wanted)
    : what_(std::move(what)), visible_(wanted && ::isatty(STDERR_FILENO) == 1) {}

JobPercentage::~JobPercentage() {
    if (shown_) std::fputs(wipe, stderr);
}

void JobPercentage::show(const proto::JobStatus& job) {
    if (!visible_) return;
    fmt::print(stderr, "{}{}: {:.0f}% {}", wipe, what_, 100.0 * job.progress(), toTerminalText(job.phase()));
    std::fflush(stderr);
    shown_ = true;
}

}  // namespace mote::client
