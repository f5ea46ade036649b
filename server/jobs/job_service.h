// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobService: the job queue on a thread of its own. What the queue does with files takes as long as the disk
// likes: requests and uploads are looked at, stored and removed there, and only who asked waits for it. Owned
// by the server; all functions on the thread of `home`, where changes are told too.
#pragma once

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/thread_pool.hpp>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/look/look_runs.h"
#include "server/jobs/uploads.h"

namespace mote::server {

class JobService {
  public:
    /// What is done on the queue's thread; it may use whatever else belongs to that thread.
    using Question = std::function<Result<proto::ServerMessage>(JobQueue&)>;
    using Answered = std::function<void(Result<proto::ServerMessage>)>;
    using Counts = std::map<std::string, std::size_t>;

    /// Nothing is touched before start(). `home` outlives it.
    JobService(asio::io_context& home, JobSettings settings);
    /// Running jobs go on. Waits for what is done on the disk.
    ~JobService();
    JobService(const JobService&) = delete;
    JobService& operator=(const JobService&) = delete;

    /// Starts the queue, on the thread that calls, and then its own one. `changed` is called after each
    /// change of a job with what it is then. Errors: as JobQueue::start.
    Status start(JobQueue::Listener changed);
    /// As JobQueue::stop, soon; questions are still answered.
    void stop();

    /// `answered` is called once, on the queue's thread, unless the service ends first. What changes after
    /// that is told after it.
    void ask(Question question, Answered answered);
    /// As JobQueue::fetchArtifact; `done` is called on the queue's thread.
    void fetchArtifact(const proto::FetchFilm& request, JobQueue::ArtifactListener done);

    /// As listFolder; `done` is called on a thread that reads folders, unless the service ends first. A
    /// folder of a slow disk delays who else asks for one, and nobody else.
    void listFolder(const proto::ListFolder& wanted, std::function<void(Result<proto::Folder>)> done);
    /// As LookRuns::look; `done` is called on the queue's thread. What is returned ends it.
    LookRuns::Ticket look(const proto::LookAtFile& wanted, LookRuns::Answered done);
    void cancelLook(LookRuns::Ticket ticket);

    /// As JobQueue::counts, when a job changed last.
    const Counts& counts() const { return *counts_; }
    /// As JobQueue::uploads; after start().
    const std::filesystem::path& uploads() const { return queue_.uploads(); }
    /// Removes a folder of the state directory that nobody uses any more. Any thread, and after the end does
    /// nothing: what it does not come to, the next start removes.
    Uploads::Remove remover();

  private:
    Status startLooks();
    void tell(const proto::JobStatus& job);
    void tellCounts();

    asio::io_context& home_;
    const std::vector<std::string> ownRoots_;  // the user's, as given
    storage::Roots roots_;                     // these, after start()
    const std::shared_ptr<asio::io_context> context_ = std::make_shared<asio::io_context>(1);
    asio::executor_work_guard<asio::io_context::executor_type> work_;
    JobQueue queue_;                 // of the thread, once that runs
    std::optional<LookRuns> looks_;  // likewise
    LookRuns::Ticket tickets_ = 0;   // given so far
    JobQueue::Listener changed_;
    const std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();  // of home's thread
    std::thread thread_;
    asio::thread_pool folders_{1};  // reads them
};

}  // namespace mote::server
