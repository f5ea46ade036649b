// SPDX-License-Identifier: GPL-3.0-or-later
//
// The inside of JobQueue: the state machine of jobs, between the table that remembers them, the runner that
// runs them and the files they leave. Same owner and thread; handlers of Asio hold it weakly.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <map>
#include <optional>

#include "server/jobs/job_files.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/job_table.h"
#include "server/jobs/runner.h"
#include "storage/files/file_descriptor.h"
#include "storage/roots.h"

namespace mote::server {

class JobQueue::Impl : public std::enable_shared_from_this<Impl> {
  public:
    Impl(asio::io_context& context, JobSettings settings);

    Status start();
    void stop();
    Result<proto::JobStatus> submit(const proto::JobRequest& request);
    Status cancel(std::string_view id);
    std::vector<proto::JobStatus> list() const;
    Result<proto::JobStatus> find(std::string_view id) const;
    void onChange(Listener listener) { listener_ = std::move(listener); }

  private:
    /// A job that runs now.
    struct Active {
        JobFiles files;
        std::unique_ptr<Run> run;
    };

    Status openState();
    void goOn();
    void goOnWith(JobRecord& record);
    void removeStrayDirectories();

    void scheduleSoon();
    void schedule();
    void begin(JobRecord& record);
    Result<std::unique_ptr<Run>> launch(JobRecord& record, JobFiles& files);
    void watch(std::int64_t number, Active active);
    void watchSoon();
    void look();

    void end(std::int64_t number);
    void conclude(JobRecord& record, JobFiles& files);
    void interrupted(JobRecord& record, JobFiles& files);
    void finish(JobRecord& record, proto::JobStatus::State state, std::string error = {});

    /// Stores the record and tells the listener, soon.
    void changed(const JobRecord& record);
    std::filesystem::path directoryOf(const JobRecord& record) const;

    asio::io_context& context_;
    JobSettings settings_;
    storage::Roots roots_;
    storage::FileDescriptor lock_;  // held: no other server has this state directory
    std::optional<JobTable> table_;
    std::unique_ptr<Runner> runner_;
    std::map<std::int64_t, Active> active_;  // by the job's number
    asio::steady_timer timer_;
    Listener listener_;
    bool scheduling_ = false;  // schedule() is posted
    bool looking_ = false;     // the timer runs
};

}  // namespace mote::server
