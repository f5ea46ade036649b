// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/jobs.h"

#include <fmt/format.h>

#include <string_view>

#include "protocol/scene/film/check_script.h"
#include "protocol/scene/utf8.h"

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
    return job.request().has_film() && job.state() == Job::SUCCEEDED;
}

}  // namespace mote::client
