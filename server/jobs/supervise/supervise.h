// SPDX-License-Identifier: GPL-3.0-or-later
//
// The parts of mote-supervise: what it is told, what it takes away from a job's program, where the program
// makes its output, and how it ended. One thread.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {

/// Rights: what a job may do, which may have to do with foreign files; all else is given up before it begins
/// and never regained. Used in the child that becomes the job's program.
struct Rights {
    std::vector<std::filesystem::path> readable;    ///< folders and files
    std::vector<std::filesystem::path> executable;  ///< folders and files, read as well
    std::vector<std::filesystem::path> writable;    ///< folders and files, read as well
    std::uint64_t memory = 0;                       ///< bytes; 0: three quarters of the machine's
    std::uint64_t fileSize = 0;                     ///< bytes, of each file; 0: as the disk has room
    int niceness = 0;                               ///< steps below the present priority, at least 0
    bool unixSockets = false;                       ///< these may be opened
    bool launcher = false;                          ///< mpirun: any sockets, and other processes
};

/// No core files, less memory, no file larger than there is room for, a lower priority, no privileges.
/// Errors: internal.
Status limitResources(const Rights& rights);

/// Landlock: the file system but for these folders disappears; so do TCP, abstract sockets and the processes
/// of others, as far as the kernel can. Folders that do not exist are left out. Errors: unsupported (a kernel
/// without it), permissionDenied (a writable folder became a link), internal.
Status limitFiles(const Rights& rights);

/// The kernel's version of Landlock; less than 1: it has none.
long landlockVersion();

/// Seccomp: the calls that such a program needs, and no others. Called in the process that is limited, once
/// it has all other limits. Errors: unsupported.
Status limitCalls(const Rights& rights);

/// Order: what mote-supervise is to do, as its command line says. A value; RunOrder (server/jobs/runner.h) is
/// what the server makes it from.
struct Order {
    std::string directory;
    Rights rights;
    std::uint32_t timeLimit = 0;  ///< s; 0: none
    bool gate = true;             ///< wait for the byte
    bool publishes = false;       ///< what it makes is given its place afterwards
    bool grows = false;           ///< which may be further steps of the live dataset there
    bool unconfined = false;      ///< it runs even with rights that cannot be taken away
    std::vector<char*> program;   ///< and its arguments, a null pointer last
};

/// The program's arguments point into argv. Nothing where the command line is wrong.
std::optional<Order> parseOrder(int argc, char** argv);

/// What --help prints.
extern const char* const orderHelp;

/// Staging: the folder beside an output's place in which a job makes it, and the only one that the job may
/// write to. The supervisor makes the folder, and once nothing of the job runs any more gives what lies there
/// its place, or throws it away. Move-only; one owner.
class Staging {
  public:
    /// `folder` and `output` are real paths of one parent; what an earlier attempt left there goes. Errors:
    /// permissionDenied, notFound, resourceExhausted, internal. `grows`: what is made may be further steps of
    /// a live dataset.
    static Result<Staging> create(const std::filesystem::path& folder, const std::filesystem::path& output,
                                  bool grows = false);

    Staging(Staging&&) noexcept = default;
    Staging& operator=(Staging&&) = delete;
    /// Removes the folder and what is left in it.
    ~Staging();

    const std::filesystem::path& folder() const { return folder_; }

    /// Gives folder/NAME, which the job has put on the disk, its place, which must be free, or puts the steps
    /// in it into the dataset there. Errors: notFound (the job made nothing), corrupt (it made other things
    /// than files and folders of its own), alreadyExists, resourceExhausted, internal; as
    /// storage::growDataset.
    Status publish();

  private:
    Staging(storage::FileDescriptor parent, std::filesystem::path folder, std::filesystem::path output,
            bool grows)
        : parent_(std::move(parent)), folder_(std::move(folder)), output_(std::move(output)), grows_(grows) {}

    storage::FileDescriptor parent_;  ///< of both, whatever its name is by now; none: moved from
    std::filesystem::path folder_;
    std::filesystem::path output_;
    bool grows_;
};

/// ChildEnd: how a supervised program came to its end. The child leads a process group of its own; SIGTERM
/// and SIGCHLD are blocked.
struct ChildEnd {
    int status = 0;     ///< as waitpid has it
    bool late = false;  ///< its time limit ended it
};

/// Waits for the child's end, hands SIGTERM on, or sends it when `timeLimit` seconds are over (0: never), and
/// sees to it that it is obeyed. Then nothing of the child is left.
ChildEnd waitForEnd(pid_t child, const sigset_t& signals, std::uint32_t timeLimit);

/// What the job came to, in a line: "exit CODE", "signal NUMBER" or "timeout SECONDS".
std::string resultOf(const ChildEnd& end, std::uint32_t timeLimit);

// What a job leaves running: processes whose parents have gone belong to the supervisor, whatever session or
// group they gave themselves.

/// From now on what its children leave behind becomes this process's own.
void adoptLeftovers();

/// Kills this process's children, and theirs as they come, until there are none.
void killLeftovers();

}  // namespace mote::server
