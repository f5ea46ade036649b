// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film/film_jobs.h"

#include <fmt/format.h>

#include "client/view/replot.h"
#include "protocol/scene/film/check_script.h"

namespace mote::client {

proto::JobRequest filmRequest(const proto::Script& script, const std::string& video) {
    constexpr std::size_t longestName = 160;  // bytes; a title is no place for more
    const auto datasets = datasetsOf(script);
    auto of = datasets.empty() ? "nothing" : datasets.front().substr(0, longestName);
    if (datasets.size() > 1) of += fmt::format(" and {} more", datasets.size() - 1);
    proto::JobRequest request;
    request.set_title(
        fmt::format("{} of {}, {} frames", video.empty() ? "pictures" : video, of, frameCountOf(script)));
    *request.mutable_film()->mutable_script() = script;
    request.mutable_film()->set_video(video);
    return request;
}

std::string jobName(const proto::JobRequest& request) {
    if (!request.output().empty()) return datasetName(request);
    if (!request.title().empty()) return request.title();
    return request.has_film() ? "film" : "job";
}

bool isReadyFilm(const proto::JobStatus& job) {
    return job.request().has_film() && job.state() == proto::JobStatus::SUCCEEDED;
}

}  // namespace mote::client
