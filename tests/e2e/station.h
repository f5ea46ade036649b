// SPDX-License-Identifier: GPL-3.0-or-later
//
// Station: what every end-to-end test needs: a folder with a small beam run and a plot of it, made by the
// real mote-prep, and a real mote-server on it. One owner; the server ends with it.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "tests/e2e/process.h"
#include "tests/support/temp_dir.h"

namespace mote::test {

std::filesystem::path program(const std::string& name);

/// A folder with `run.h5` and `beam.mote` of 20,000 particles and two steps, made once a test program and
/// only read. Throws std::runtime_error with what mote-prep said.
const std::filesystem::path& beamFolder();

class Station {
  public:
    /// Its root "data" holds copies, which a test may change. Starts no server yet.
    Station();
    ~Station();
    Station(const Station&) = delete;
    Station& operator=(const Station&) = delete;

    /// Waits until it is ready. Throws std::runtime_error with what it said.
    void startServer(const std::string& name = "mote-server");
    /// As startServer(), but of several ranks under mpirun, which server() is then; after `ranks` of them
    /// with the same root comes one for each of `otherRoots`, which has that in its place.
    void startRanks(int ranks, const std::vector<std::filesystem::path>& otherRoots = {});
    Process& server() { return *server_; }

    std::filesystem::path root() const { return folder_ / "root"; }
    std::filesystem::path connection() const { return folder_ / "connection.json"; }
    std::filesystem::path out() const { return folder_ / "out"; }
    /// For TMPDIR, so that what is left behind is seen.
    std::filesystem::path temporary() const { return folder_ / "tmp"; }

    std::filesystem::path writeScript(const std::string& json) const;
    /// mote-frames SCRIPT --connect ... --out ... and more; apostrophes in the script stand for quotation
    /// marks.
    Finished frames(const std::string& script, const std::vector<std::string>& more = {},
                    const ProcessOptions& options = {}) const;
    std::vector<std::string> framesArguments(const std::string& script,
                                             const std::vector<std::string>& more) const;

  private:
    std::vector<std::string> serverArguments() const;  ///< but for its root
    void awaitServer();

    TempDir folder_;
    std::unique_ptr<Process> server_;
};

/// A view of a step of "data/beam", `width` x 3/4 `width` pixels, from `distance` in front.
std::string beamView(int width, int step = 0, double distance = 4.0,
                     const std::string& dataset = "data/beam");
std::string scriptOf(const std::vector<std::string>& views);

std::string bytesOf(const std::filesystem::path& file);
/// Names in a folder, sorted; empty if there is none.
std::vector<std::string> namesIn(const std::filesystem::path& folder);

// What a test says to a server as a client, and waits for the answers. The connection's thread.

/// False if the condition does not come true in a long while.
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
