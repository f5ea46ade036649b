// SPDX-License-Identifier: GPL-3.0-or-later
//
// Runner: how a job's program (mote-prep, or mote-frames for a film) is brought to run: `local`
// (makeLocalRunner, a child process). `mpi` (mpirun -n K mote-prep) and `slurm` (sbatch with a fixed script)
// are to stand beside it. Owned by the queue and used on its thread.
//
// Whatever the runner, a job leaves files in its directory (JobFiles): progress and log while it runs, and at
// last a result, written by one rename. A run that has ended without one was interrupted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scene/error.h"

namespace asio {
class io_context;
}

namespace mote::server {

/// The descriptor to which a job's program writes its progress.
inline constexpr int progressDescriptor = 3;

/// What is to run. The user's own words are in the request file only, never in an argument.
struct RunOrder {
    std::filesystem::path directory;              ///< of the job, holds request.json; it may be read
    std::vector<std::string> program;             ///< its path, and its arguments
    std::vector<std::filesystem::path> readable;  ///< folders that it may read
    std::filesystem::path writable;               ///< the folder that it may write
    std::uint64_t memory = 0;                     ///< bytes; 0: no limit
    int niceness = 0;                             ///< steps below the server's priority
    bool unixSockets = false;                     ///< it may open these; no others ever
};

/// A job that runs, or waits for go(). Destroying it stops watching, never the job.
class Run {
  public:
    virtual ~Run() = default;
    /// What find() knows it by, in this server or the next.
    virtual std::string handle() const = 0;
    /// Begins. Called once the handle is stored: without it nothing begins, even if this server is killed
    /// first.
    virtual void go() = 0;
    /// `ended` is called once, from the io_context, when nothing of the job runs any more.
    virtual void onEnd(std::function<void()> ended) = 0;
    /// Asks it to end, SIGTERM first and SIGKILL 5 s later; onEnd follows.
    virtual void cancel() = 0;
};

class Runner {
  public:
    virtual ~Runner() = default;
    /// Errors: internal, notFound (the program).
    virtual Result<std::unique_ptr<Run>> start(const RunOrder& order) = 0;
    /// A run of this or an earlier server; null where it has ended.
    virtual std::unique_ptr<Run> find(std::string_view handle) = 0;
};

/// Runs programs on this machine, under mote-supervise (`supervisor` is its path), which has a session of its
/// own, takes rights away from the program, waits for it and writes its result. The context outlives the
/// runner and its runs.
std::unique_ptr<Runner> makeLocalRunner(asio::io_context& context, std::filesystem::path supervisor);

}  // namespace mote::server
