// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/e2e/conversation.h"

#include <gtest/gtest.h>

namespace mote::test {

using client::Connection;

std::vector<std::string> datasets(Connection& connection) {
    const auto catalogue =
        answer<proto::Catalogue>(connection, [&](auto reply) { connection.listDatasets(reply); });
    std::vector<std::string> names;
    if (catalogue.ok()) {
        for (const auto& entry : catalogue->datasets()) names.push_back(entry.name());
    }
    return names;
}

std::string submit(Connection& connection, const proto::JobRequest& request) {
    const auto job =
        answer<proto::JobStatus>(connection, [&](auto reply) { connection.submitJob(request, reply); });
    EXPECT_TRUE(job.ok()) << job.error().toString();
    return job.ok() ? job->id() : "";
}

proto::JobStatus reached(Connection& connection, const std::string& id, proto::JobStatus::State state,
                         std::vector<double>* progress) {
    proto::JobStatus last;
    const auto take = [&](const proto::JobStatus& status) {
        if (status.id() != id) return;
        last = status;
        if (progress != nullptr) progress->push_back(status.progress());
    };
    connection.onJob(take);
    const auto jobs = answer<proto::Jobs>(connection, [&](auto reply) { connection.watchJobs(reply); });
    EXPECT_TRUE(jobs.ok());
    // What changed after the answer has come through the listener already and is newer.
    if (jobs.ok() && last.id().empty()) {
        for (const auto& job : jobs->jobs()) take(job);
    }
    EXPECT_TRUE(eventually(connection, [&] { return last.state() >= state; }));
    connection.onJob({});
    return last;
}

}  // namespace mote::test
