// SPDX-License-Identifier: GPL-3.0-or-later
//
// Process: a program under test, with what it writes captured. One owner, one thread; a process that still
// runs when the object goes is killed and waited for.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace mote::test {

struct ProcessOptions {
    std::map<std::string, std::string> environment;  ///< set in addition to our own
    std::optional<std::uint64_t> fileSizeLimit;      ///< bytes; a stand-in for a full disk
};

class Process {
  public:
    using Timeout = std::chrono::milliseconds;
    static constexpr Timeout patience{60'000};  ///< for anything that is expected to happen

    /// Throws std::system_error.
    Process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const ProcessOptions& options = {});
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t id() const { return id_; }
    void signal(int number) const;
    /// The exit status, 128 and the signal's number where one ended it; empty after the timeout.
    std::optional<int> wait(Timeout timeout = patience);
    /// Reads until stdout holds `text`; false where the process ends or time runs out before.
    bool waitForOutput(const std::string& text, Timeout timeout = patience);

    const std::string& output() const { return output_; }  ///< stdout so far
    const std::string& errors() const { return errors_; }  ///< stderr so far

  private:
    using Time = std::chrono::steady_clock::time_point;
    /// Reads what comes until then; true once the process has ended.
    bool readUntil(Time end);
    void drain();

    pid_t id_ = -1;
    int process_ = -1;  // pidfd
    int outputPipe_ = -1, errorPipe_ = -1;
    std::optional<int> status_;
    std::string output_, errors_;
};

/// Waits for the end of a process that is no child of ours; false after the timeout.
bool waitForEnd(pid_t process, Process::Timeout timeout = Process::patience);

/// How a finished process ended, for assertions: runs it to its end. 124 where it does not end in time.
struct Finished {
    int status = 0;
    std::string output, errors;
};
Finished runProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    const ProcessOptions& options = {});

}  // namespace mote::test
