// SPDX-License-Identifier: GPL-3.0-or-later
//
// Runner: how a job's program (mote-prep, or mote-frames for a film) is brought to run: a child process
// (makeLocalRunner), or a job of Slurm (makeSlurmRunner). Owned by the queue and used on its thread.
//
// Whatever the runner, the program runs under mote-supervise, and leaves files in its directory (JobFiles):
// progress and log while it runs, and at last a result, written by one rename. A run that has ended without
// one was interrupted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace asio {
class io_context;
}

namespace mote::server {

struct JobSettings;

/// The descriptor to which a job's program writes its progress.
inline constexpr int progressDescriptor = 3;

/// What is to run. The user's own words are in the request file only, never in an argument.
struct RunOrder {
    std::filesystem::path directory;              ///< of the job, holds request.json; it may be read
    std::vector<std::string> program;             ///< its path, and its arguments
    std::vector<std::filesystem::path> readable;  ///< folders that it may read
    std::filesystem::path writable;               ///< the folder that it may write; empty where it publishes
    bool publishes = false;                       ///< `directory` says where its output is to lie (JobFiles)
    bool grows = false;             ///< where a live dataset may lie that gets it as further steps
    bool unconfined = false;        ///< it runs even where no rights can be taken from it
    std::filesystem::path scratch;  ///< of its launcher, which it may write; empty: none
    std::uint64_t memory = 0;       ///< bytes; 0: no limit
    int niceness = 0;               ///< steps below the server's priority
    bool unixSockets = false;       ///< it may open these; no others, but a launcher
    bool launcher = false;          ///< mpirun: it starts processes, which talk to each other
    std::uint32_t timeLimit = 0;    ///< s, of the run; 0: none
    std::uint64_t fileSize = 0;     ///< bytes, of each file that it writes to; 0: no limit of its own
    unsigned cores = 1;             ///< that it keeps busy, for a runner that deals them out
};

/// What is known of a run that has ended, besides the files that it left.
struct RunEnd {
    std::string how;    ///< one sentence, where it was lost; empty: not known
    bool again = true;  ///< it was nobody's limit that ended it: another run may come further
};

/// A job that runs, or waits for go(). Destroying it stops watching, never the job.
class Run {
  public:
    virtual ~Run() = default;
    /// What find() knows it by, in this server or the next.
    virtual std::string handle() const = 0;
    /// What people find it by: the number of a process or of a Slurm job.
    virtual std::string id() const = 0;
    /// Begins. Called once the handle is stored: without it nothing begins, even if this server is killed
    /// first.
    virtual void go() = 0;
    /// `ended` is called once, from the io_context, when nothing of the job runs any more.
    virtual void onEnd(std::function<void(RunEnd)> ended) = 0;
    /// Asks it to end, SIGTERM first and SIGKILL some seconds later; onEnd follows.
    virtual void cancel() = 0;
};

class Runner {
  public:
    using Started = std::function<void(Result<std::unique_ptr<Run>>)>;

    virtual ~Runner() = default;
    /// `started` is called once, from within or later from the io_context, with a run that waits for go():
    /// destroyed before that, it never begins. Errors: internal, notFound (the program), resourceExhausted
    /// and permissionDenied (the place is to blame, and it may go well later).
    virtual void start(const RunOrder& order, Started started) = 0;
    /// A run of this or an earlier server; null where it has ended, or is none of this runner's. Errors:
    /// resourceExhausted, internal (whether it has ended cannot be known now).
    virtual Result<std::unique_ptr<Run>> find(std::string_view handle) = 0;
    /// Before anything is started: what an earlier server had prepared for these jobs (their ids), and was
    /// killed before it had stored so, never begins.
    virtual void forget(const std::vector<std::string>& /*jobs*/) {}
};

/// Runs programs on this machine, under mote-supervise (`supervisor` is its path), which has a session of its
/// own, takes rights away from the program, waits for it and writes its result. The context outlives the
/// runner and its runs.
std::unique_ptr<Runner> makeLocalRunner(asio::io_context& context, std::filesystem::path supervisor);

/// The words with which mote-supervise is started for an order, its own path first.
std::vector<std::string> supervisorArguments(const RunOrder& order, const std::string& supervisor);

/// The programs of Slurm are those in PATH (checkRunner); STATE and the roots must lie where its nodes see
/// them. The context outlives the runner and its runs. Errors: permissionDenied, resourceExhausted, internal
/// (the script cannot be written).
Result<std::unique_ptr<Runner>> makeSlurmRunner(asio::io_context& context, const JobSettings& settings);

/// Whether there is such a runner, and its programs are in PATH. `ranks`: of a job. Errors: invalidArgument
/// (there is no such runner), notFound (the first program that is missing).
Status checkRunner(std::string_view runner, unsigned ranks);

/// Runners: those of a server. Films run on its own machine always.
class Runners {
  public:
    /// `handles`: of runs that an earlier server began; `waiting`: ids of jobs that none was stored for.
    /// Errors: as checkRunner and makeSlurmRunner. Runs of Slurm are found again by a server that runs its
    /// jobs otherwise now; where there is no Slurm any more they are lost, and the server is not.
    static Result<Runners> open(asio::io_context& context, const JobSettings& settings,
                                const std::vector<std::string>& handles,
                                const std::vector<std::string>& waiting);

    Runner& of(bool film) const { return useSlurm_ && !film ? *slurm_ : *local_; }
    /// As Runner::find.
    Result<std::unique_ptr<Run>> find(std::string_view handle) const;
    /// Of a run that was not found. Where nobody can be asked it may still run: it is not begun a second
    /// time.
    RunEnd endOfLost(std::string_view handle) const;

  private:
    Runners() = default;

    std::unique_ptr<Runner> local_, slurm_;  // slurm_: null where there is no such runner
    bool useSlurm_ = false;
};

}  // namespace mote::server
