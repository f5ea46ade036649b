// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/run_command.h"

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
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "protocol/scene/system_error.h"
#include "server/jobs/job_files.h"
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

}  // namespace

void runCommand(asio::io_context& context, std::vector<std::string> words, Done done) {
    std::make_shared<Command>(context, std::move(words), std::move(done))->start();
}

}  // namespace mote::server
