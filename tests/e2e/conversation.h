// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a test says to a server as a client, and waits for the answers. The connection's thread.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "tests/e2e/process.h"

namespace mote::test {

/// False where the condition does not come true in a long while.
template <class Condition>
bool eventually(client::Connection& connection, const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + Process::patience;
    while (std::chrono::steady_clock::now() < end) {
        connection.poll();
        if (condition()) return true;
        connection.wait(std::chrono::milliseconds(50));
    }
    return false;
}

template <class T>
Result<T> answer(client::Connection& connection,
                 const std::function<void(client::Connection::Reply<T>)>& ask) {
    std::optional<Result<T>> got;
    ask([&](Result<T> result) { got = std::move(result); });
    if (!eventually(connection, [&] { return got.has_value(); })) {
        return Error{ErrorCode::internal, "", "no answer"};
    }
    return *got;
}

/// Names of the catalogue.
std::vector<std::string> datasets(client::Connection& connection);

/// The id of the job; a failure of the test where it is refused.
std::string submit(client::Connection& connection, const proto::JobRequest& request);

/// Watches a job until its state is `state` or one in which it has ended; returns its last status. `progress`
/// gets every one of its reports.
proto::JobStatus reached(client::Connection& connection, const std::string& id, proto::JobStatus::State state,
                         std::vector<double>* progress = nullptr);
inline proto::JobStatus ended(client::Connection& connection, const std::string& id,
                              std::vector<double>* progress = nullptr) {
    return reached(connection, id, proto::JobStatus::SUCCEEDED, progress);
}

}  // namespace mote::test
