// SPDX-License-Identifier: GPL-3.0-or-later
//
// Process: a program under test, with what it writes captured. One owner, one thread; a process that still
// runs when the object goes is killed and waited for.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <fstream>
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
    /// Reads until stdout holds `text`; false if the process ends or time runs out before.
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

/// How a finished process ended, for assertions: runs it to its end. 124 if it does not end in time.
struct Finished {
    int status = 0;
    std::string output, errors;
};
Finished runProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    const ProcessOptions& options = {});

// What mpirun needs to be told in tests, and what it started. Functions without state.

/// mpirun refuses root, and more ranks than cores, unless told: tests run in both. It asks no X server for
/// GPUs, as those of other tests end meanwhile, and is not bound to cores that others use. `folder` takes its
/// temporary files.
inline ProcessOptions mpiEnvironment(const std::filesystem::path& folder) {
    ProcessOptions options;
    options.environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                           {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                           {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
                           {"PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"},  // of Open MPI 5
                           {"OMPI_MCA_hwloc_base_binding_policy", "none"},
                           {"PRTE_MCA_hwloc_default_binding_policy", "none"},
                           {"HWLOC_COMPONENTS", "-gl"},
                           {"OMPI_MCA_btl_vader_single_copy_mechanism", "none"},
                           {"TMPDIR", folder.string()}};
    return options;
}

/// The processes that a process has started.
inline std::vector<pid_t> childrenOf(pid_t process) {
    std::vector<pid_t> children;
    std::error_code ignored;
    for (const auto& thread :
         std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", ignored)) {
        std::ifstream file(thread.path() / "children");
        for (pid_t child = 0; file >> child;) children.push_back(child);
    }
    return children;
}

}  // namespace mote::test
