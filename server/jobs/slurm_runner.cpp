// SPDX-License-Identifier: GPL-3.0-or-later
//
// The runner that hands jobs to Slurm. Each becomes a batch job named "mote-ID" on one node: a fixed script
// that starts mote-supervise with the words that it gets; the user's own words are in the request file only.
// It is submitted held, and released once its number is stored. How it goes is asked of squeue, and of sacct
// where that knows it no more.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <asio/io_context.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "protocol/base/system_error.h"
#include "protocol/base/utf8.h"
#include "server/jobs/job_environment.h"
#include "server/jobs/job_files.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/slurm_state.h"
#include "server/log.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;
using Done = std::function<void(Result<std::string>)>;

constexpr std::chrono::seconds kPatience(60);
constexpr std::size_t kMostOutput = std::size_t{4} << 20;  // bytes
constexpr std::size_t kLongestReason = 300;                // bytes

/// Output goes to memory: nobody need read while it runs.
FileDescriptor memoryFile(const char* name) {
    return FileDescriptor(memfd_create(name, MFD_CLOEXEC));
}

std::string contentOf(const FileDescriptor& file) {
    struct stat status {};
    if (!file.valid() || fstat(file.get(), &status) != 0) return {};
    std::string text(std::min(static_cast<std::size_t>(status.st_size), kMostOutput), '\0');
    const auto got = pread(file.get(), text.data(), text.size(), 0);
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return text;
}

std::string lastLine(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    return plainText(text.substr(text.rfind('\n') + 1), kLongestReason);
}

/// Lives as long as its handlers.
class Command : public std::enable_shared_from_this<Command> {
  public:
    Command(asio::io_context& context, std::vector<std::string> words, Done done)
        : words_(std::move(words)), done_(std::move(done)), process_(context), deadline_(context) {}

    void start() {
        const int error = spawn();
        if (error != 0) {
            const auto code = error == ENOENT ? ErrorCode::notFound : ErrorCode::resourceExhausted;
            return later(Error{code, words_.front(), "cannot be started: " + systemMessage(error)});
        }
        const int process = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
        std::error_code code;
        if (process >= 0) process_.assign(process, code);
        if (process < 0 || code) {
            kill(pid_, SIGKILL);
            waitpid(pid_, nullptr, 0);
            return later(Error{ErrorCode::resourceExhausted, words_.front(), "cannot be watched"});
        }
        process_.async_wait(asio::posix::stream_descriptor::wait_read,
                            [self = shared_from_this()](const std::error_code& failed) {
                                if (!failed) self->ended();
                            });
        deadline_.expires_after(kPatience);
        deadline_.async_wait([self = shared_from_this()](const std::error_code& failed) {
            if (failed) return;
            self->late_ = true;
            kill(self->pid_, SIGKILL);
        });
    }

  private:
    /// 0 or an errno.
    int spawn() {
        std::vector<char*> argv;
        for (auto& word : words_) argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        int error = posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
        if (error == 0) error = posix_spawn_file_actions_adddup2(&files, output_.get(), 1);
        if (error == 0) error = posix_spawn_file_actions_adddup2(&files, errors_.get(), 2);
        if (error == 0) error = posix_spawn_file_actions_addclosefrom_np(&files, 3);
        if (error == 0) error = posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&files);
        return error;
    }

    void ended() {
        deadline_.cancel();
        int status = 0;
        waitpid(pid_, &status, 0);
        auto done = std::exchange(done_, nullptr);
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return done(contentOf(output_));
        const auto said = lastLine(contentOf(errors_));
        done(Error{ErrorCode::resourceExhausted, words_.front(),
                   late_ ? "does not answer" : (said.empty() ? "failed without a word" : said)});
    }

    void later(Error error) {
        asio::post(process_.get_executor(),
                   [self = shared_from_this(), error = std::move(error)] { self->done_(error); });
    }

    std::vector<std::string> words_;
    Done done_;
    const FileDescriptor output_ = memoryFile("output"), errors_ = memoryFile("errors");
    asio::posix::stream_descriptor process_;  // a pidfd
    asio::steady_timer deadline_;
    pid_t pid_ = 0;
    bool late_ = false;
};

/// Runs a short program of the system, sbatch say, without waiting for it. `done` is called once, from the
/// io_context, with what the program (its first word, a path) printed on stdout. It has a minute. Errors:
/// notFound (the program), resourceExhausted (it failed, with what it printed last on stderr, or took too
/// long: the place is to blame).
void runCommand(asio::io_context& context, std::vector<std::string> words, Done done) {
    std::make_shared<Command>(context, std::move(words), std::move(done))->start();
}

constexpr std::string_view slurmPrefix = "slurm ";  // of handles
constexpr std::chrono::milliseconds kLongestPause(30000);

// Its words become the job's arguments, whatever they hold: nothing is put together here.
constexpr const char* kScript = R"(#!/bin/sh
# Written by mote-server, which hands it to sbatch: FOLDER-OF-THE-JOB PROGRAM [ARGUMENT]...
directory=$1
shift
exec "$@" >>"$directory/log" 2>&1
)";

/// What the runner and its runs share.
class Slurm : public std::enable_shared_from_this<Slurm> {
  public:
    struct Watched {
        std::function<void(RunEnd)> ended;  ///< empty: nobody waits for it yet
        bool released = false;              ///< it may begin
    };

    Slurm(asio::io_context& context, std::chrono::milliseconds pause)
        : context_(context), timer_(context), pause_(pause), wait_(pause) {}

    void run(const char* program, std::vector<std::string> words,
             std::function<void(Result<std::string>)> done) {
        words.insert(words.begin(), findProgram(program).string());
        runCommand(context_, std::move(words),
                   [weak = weak_from_this(), done = std::move(done)](Result<std::string> output) {
                       if (weak.lock()) done(std::move(output));
                   });
    }

    Watched& watched(std::uint64_t number) { return watched_[number]; }
    void forget(std::uint64_t number) { watched_.erase(number); }
    void release(std::uint64_t number);
    void cancel(std::uint64_t number);
    void lookSoon();

  private:
    void look();
    void compare(const std::set<std::uint64_t>& asked, const Result<std::string>& queue);
    void askAccounts(std::uint64_t number);
    void end(std::uint64_t number, const RunEnd& how);

    asio::io_context& context_;
    std::map<std::uint64_t, Watched> watched_;
    asio::steady_timer timer_;
    const std::chrono::milliseconds pause_;
    std::chrono::milliseconds wait_;  // longer while Slurm does not answer
    bool looking_ = false;
};

void Slurm::release(std::uint64_t number) {
    run("scontrol", {"release", std::to_string(number)}, [number](const Result<std::string>& said) {
        if (!said.ok()) log::warn("Slurm job {} is not released: {}", number, said.error().toString());
    });
}

void Slurm::cancel(std::uint64_t number) {
    run("scancel", {std::to_string(number)}, [number](const Result<std::string>& said) {
        if (!said.ok()) log::warn("Slurm job {} is not cancelled: {}", number, said.error().toString());
    });
}

void Slurm::lookSoon() {
    if (std::exchange(looking_, true)) return;
    timer_.expires_after(wait_);
    timer_.async_wait([weak = weak_from_this()](const std::error_code& code) {
        if (const auto self = weak.lock(); self && !code) self->look();
    });
}

void Slurm::look() {
    std::set<std::uint64_t> asked;
    for (const auto& [number, watched] : watched_) asked.insert(number);
    run("squeue", {"--me", "--noheader", "--states=all", "--format=%i|%T|%r"},
        [this, asked = std::move(asked)](const Result<std::string>& queue) {
            looking_ = false;
            compare(asked, queue);
            if (!watched_.empty()) lookSoon();
        });
}

/// `asked`: what was there when it was asked for.
void Slurm::compare(const std::set<std::uint64_t>& asked, const Result<std::string>& queue) {
    if (!queue.ok()) {
        if (wait_ == pause_) log::warn("Slurm does not answer: {}", toLogText(queue.error().toString()));
        wait_ = std::min(2 * wait_, std::max(kLongestPause, pause_));
        return;
    }
    wait_ = pause_;
    const auto jobs = parseQueue(*queue);
    for (const auto number : asked) {
        const auto watched = watched_.find(number);
        if (watched == watched_.end()) continue;
        const auto job = jobs.find(number);
        if (job == jobs.end()) {
            askAccounts(number);
        } else if (hasEnded(job->second.state)) {
            end(number, endOf(job->second.state));
        } else if (watched->second.released && job->second.reason == "JobHeldUser") {
            release(number);  // the word did not get through, or was said by a server that is gone
        }
    }
}

/// Of what squeue knows no more. Without accounting nobody knows: its files do.
void Slurm::askAccounts(std::uint64_t number) {
    run("sacct",
        {"--allocations", "--noheader", "--parsable2", "--format=State", "--jobs=" + std::to_string(number)},
        [this, number](const Result<std::string>& state) {
            end(number, state.ok() ? endOf(*state) : RunEnd());
        });
}

void Slurm::end(std::uint64_t number, const RunEnd& how) {
    const auto watched = watched_.extract(number);
    if (!watched.empty() && watched.mapped().ended) watched.mapped().ended(how);
}

// ------------------------------------------------------------------------------------------------ runs

class SlurmRun final : public Run {
  public:
    /// `begun`: by a server that is gone.
    SlurmRun(std::shared_ptr<Slurm> slurm, std::uint64_t number, bool begun)
        : slurm_(std::move(slurm)), number_(number), begun_(begun) {
        slurm_->watched(number_).released = begun_;
        slurm_->lookSoon();
    }
    ~SlurmRun() override {
        slurm_->forget(number_);
        if (!begun_) slurm_->cancel(number_);
    }
    SlurmRun(const SlurmRun&) = delete;
    SlurmRun& operator=(const SlurmRun&) = delete;

    std::string handle() const override { return fmt::format("{}{}", slurmPrefix, number_); }
    std::string id() const override { return std::to_string(number_); }
    void go() override {
        begun_ = true;
        slurm_->watched(number_).released = true;
        slurm_->release(number_);
    }
    void onEnd(std::function<void(RunEnd)> ended) override {
        slurm_->watched(number_).ended = std::move(ended);
    }
    void cancel() override { slurm_->cancel(number_); }

  private:
    const std::shared_ptr<Slurm> slurm_;
    const std::uint64_t number_;
    bool begun_;
};

std::string nameOf(const std::string& job) {
    return "mote-" + job;
}

/// Numbers, and names of our own making, only. The environment is what a login would have of it.
std::vector<std::string> batchOptions(const RunOrder& order) {
    constexpr std::uint64_t mebi = std::uint64_t{1} << 20;
    std::vector<std::string> words{"--parsable",
                                   "--hold",
                                   "--no-requeue",
                                   "--job-name=" + nameOf(order.directory.filename().string()),
                                   "--nodes=1",
                                   "--ntasks=1",
                                   fmt::format("--cpus-per-task={}", order.cores),
                                   "--export=PATH,HOME,LANG",
                                   "--chdir=/",
                                   "--input=/dev/null",
                                   "--output=/dev/null"};
    // Slurm counts what a program has mapped of files, too, and its supervisor.
    if (order.memory > 0) words.push_back(fmt::format("--mem={}M", order.memory / 10 * 11 / mebi + 64));
    // The supervisor ends it in time; this is for a node that does not.
    if (order.timeLimit > 0) words.push_back(fmt::format("--time={}", order.timeLimit / 60 + 2));
    return words;
}

class SlurmRunner final : public Runner {
  public:
    SlurmRunner(asio::io_context& context, const JobSettings& settings, std::filesystem::path script)
        : slurm_(std::make_shared<Slurm>(context, settings.slurmPoll)),
          supervisor_(settings.supervisor),
          script_(std::move(script)) {}

    void start(const RunOrder& order, Started started) override;
    Result<std::unique_ptr<Run>> find(std::string_view handle) override;
    void forget(const std::vector<std::string>& jobs) override;

  private:
    void forgetNow();
    void forgotten(const Result<std::string>& names);
    void submit(const RunOrder& order, const Started& started);

    const std::shared_ptr<Slurm> slurm_;
    const std::filesystem::path supervisor_, script_;
    std::vector<std::string> unbegun_;                  // jobs that are to be forgotten first
    std::vector<std::pair<RunOrder, Started>> starts_;  // that wait for it
    bool forgetting_ = false;
};

void SlurmRunner::start(const RunOrder& order, Started started) {
    if (unbegun_.empty()) return submit(order, started);
    starts_.emplace_back(order, std::move(started));
    forgetNow();
}

void SlurmRunner::forget(const std::vector<std::string>& jobs) {
    unbegun_ = jobs;
    if (!unbegun_.empty()) forgetNow();
}

void SlurmRunner::forgetNow() {
    if (std::exchange(forgetting_, true)) return;
    slurm_->run("squeue", {"--me", "--noheader", "--format=%i|%j"},
                [this](const Result<std::string>& names) { forgotten(names); });
}

void SlurmRunner::forgotten(const Result<std::string>& names) {
    forgetting_ = false;
    if (names.ok()) {
        const auto numbers = parseNames(*names);
        for (const auto& job : std::exchange(unbegun_, {})) {
            const auto [begin, end] = numbers.equal_range(nameOf(job));
            for (auto entry = begin; entry != end; ++entry) slurm_->cancel(entry->second);
        }
    }
    for (auto& [order, started] : std::exchange(starts_, {})) {
        names.ok() ? submit(order, started) : started(names.error());
    }
}

void SlurmRunner::submit(const RunOrder& order, const Started& started) {
    auto words = batchOptions(order);
    words.push_back(script_.string());
    words.push_back(order.directory.string());
    auto program = supervisorArguments(order, supervisor_.string());
    program.insert(program.begin() + 1, {"--gate", "none"});
    words.insert(words.end(), program.begin(), program.end());
    slurm_->run("sbatch", std::move(words), [this, started](const Result<std::string>& said) {
        if (!said.ok()) return started(said.error());
        const auto number = parseNumber(*said);
        if (!number) return started(Error{ErrorCode::internal, "sbatch", "said no number of a job"});
        started(std::unique_ptr<Run>(std::make_unique<SlurmRun>(slurm_, *number, false)));
    });
}

Result<std::unique_ptr<Run>> SlurmRunner::find(std::string_view handle) {
    std::unique_ptr<Run> run;
    const auto number =
        handle.starts_with(slurmPrefix) ? parseNumber(handle.substr(slurmPrefix.size())) : std::nullopt;
    if (number) run = std::make_unique<SlurmRun>(slurm_, *number, true);
    return run;
}

}  // namespace

Result<std::unique_ptr<Runner>> makeSlurmRunner(asio::io_context& context, const JobSettings& settings) {
    const auto script = settings.stateDirectory / "slurm-job.sh";
    std::error_code code;
    std::filesystem::remove(script, code);
    MOTE_RETURN_IF_ERROR(storage::writeNewFile(script, kScript));
    return std::unique_ptr<Runner>(std::make_unique<SlurmRunner>(context, settings, script));
}

}  // namespace mote::server
