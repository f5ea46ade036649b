// SPDX-License-Identifier: GPL-3.0-or-later
//
// A state directory, a root with fifos and a queue over the fake mote-prep; events are waited for on the
// queue's own io_context, never slept for.
#pragma once

#include <gtest/gtest.h>

#include <asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/jobs/job_queue.h"

namespace mote::server {

class JobTest : public ::testing::Test {
  protected:
    using State = proto::JobStatus;

    JobTest();
    ~JobTest() override;

    JobSettings settings() const;
    /// A fresh queue, as a server that has been started (again). The old one is destroyed: its jobs go on.
    void startServer(JobSettings settings);
    void startServer() { startServer(settings()); }
    void killServer();

    /// A synthetic run whose title is the fake's script.
    proto::JobRequest request(const std::string& script, const std::string& output = "data/run.h5") const;
    /// Submits what must be accepted; its id.
    std::string submit(const std::string& script, const std::string& output = "data/run.h5");

    /// A film job, likewise, and what it has left or is told through.
    proto::JobRequest filmRequest(const std::string& script) const;
    std::string submitFilm(const std::string& script);
    std::filesystem::path filmFile(const std::string& id, const std::string& name) const {
        return directory_ / "state/jobs" / id / "film" / name;
    }
    /// Lets a film go on that waits at this fifo.
    void releaseFilm(const std::string& id, const std::string& name);
    /// Waits for the answer.
    Result<ArtifactPiece> fetch(const proto::FetchFilm& request);
    Result<ArtifactPiece> fetchPicture(const std::string& id, std::uint32_t frame, std::uint64_t begin = 0);
    Result<ArtifactPiece> fetchVideo(const std::string& id, std::uint64_t begin = 0);

    /// Runs the queue until the job's status is like this; fails the test after half a minute.
    proto::JobStatus waitUntil(const std::string& id,
                               const std::function<bool(const proto::JobStatus&)>& wanted);
    proto::JobStatus waitForState(const std::string& id, proto::JobStatus::State state);
    proto::JobStatus waitForPhase(const std::string& id, const std::string& phase);
    /// Runs what is ready now.
    void settle();
    /// Waits for what other threads or processes do; false where that does not come within half a minute.
    bool comes(const std::function<bool()>& wanted);

    /// A fifo in the root, held open: a byte written to it waits there for its reader.
    void makeFifo(const std::string& name);
    void release(const std::string& name);

    std::filesystem::path directory_;  // fresh, removed at the end
    std::filesystem::path root_;
    std::unique_ptr<asio::io_context> context_;
    std::unique_ptr<JobQueue> queue_;
    std::vector<proto::JobStatus> changes_;  // all that the queue told

  private:
    std::vector<std::pair<std::string, int>> fifos_;
};

/// Waits until the process has ended, without taking its status from anyone.
void waitForEnd(int pid);

}  // namespace mote::server
