// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is not allowed is answered with ENOSYS, as by a kernel that lacks it: libraries try the newest call
// first and are prepared for that answer, which is not so for EPERM.
#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <utility>

#include "protocol/base/system_error.h"
#include "server/jobs/supervise/call_lists.h"
#include "server/jobs/supervise/supervise.h"

namespace mote::server {
namespace {

constexpr std::uint64_t kNamespaces =
    CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;

class Filter {
  public:
    Filter() : context_(seccomp_init(SCMP_ACT_ERRNO(ENOSYS)), seccomp_release) {
        // Calls of another architecture (32 bits) have other numbers.
        good_ = context_ &&
                seccomp_attr_set(context_.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_ERRNO(ENOSYS)) == 0;
    }

    void allow(std::span<const int> calls) {
        for (const int call : calls) add(call, {});
    }
    /// Where all conditions hold. Of one call any number of such rules.
    void allow(int call, std::initializer_list<scmp_arg_cmp> conditions) { add(call, conditions); }

    Status load() const {
        const int error = good_ ? -seccomp_load(context_.get()) : ENOMEM;
        if (error == 0) return success();
        return Error{ErrorCode::unsupported, "",
                     "seccomp cannot filter this job's calls: " + systemMessage(error), error == ENOMEM};
    }

  private:
    void add(int call, std::initializer_list<scmp_arg_cmp> conditions) {
        if (!good_) return;
        // A call that this processor does not have has nothing to be allowed.
        const int error =
            seccomp_rule_add_array(context_.get(), SCMP_ACT_ALLOW, call,
                                   static_cast<unsigned>(conditions.size()), conditions.begin());
        good_ = error == 0 || error == -EDOM;
    }

    std::unique_ptr<void, void (*)(scmp_filter_ctx)> context_;
    bool good_ = false;
};

/// `argument` & mask == value.
scmp_arg_cmp masked(unsigned argument, std::uint64_t mask, std::uint64_t value) {
    return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

/// The low half alone: an int's upper half is nobody's.
scmp_arg_cmp equals(unsigned argument, std::uint64_t value) {
    return masked(argument, 0xffffffff, value);
}

/// Memory that is shared and no file's is counted to nobody (limitResources).
void allowMappings(Filter& filter) {
    constexpr std::uint64_t kinds = MAP_SHARED | MAP_ANONYMOUS;
    for (const std::uint64_t kind : {0, MAP_SHARED, MAP_ANONYMOUS})
        filter.allow(SCMP_SYS(mmap), {masked(3, kinds, kind)});
}

/// Before its version 3 Landlock lets everyone cut a file that is opened to be read; openat2() hides its
/// flags.
void allowOpening(Filter& filter) {
    for (const auto& [call, flags] : {std::pair(SCMP_SYS(open), 1U), std::pair(SCMP_SYS(openat), 2U)}) {
        filter.allow(call, {masked(flags, O_TRUNC, 0)});
        filter.allow(call, {masked(flags, O_ACCMODE, O_WRONLY)});
        filter.allow(call, {masked(flags, O_ACCMODE, O_RDWR)});
    }
    if (landlockVersion() >= 3) filter.allow(SCMP_SYS(openat2), {});
}

/// A program of one process: threads, no children, and signals to itself alone, its number being ours.
void allowOneProcess(Filter& filter) {
    const auto self = static_cast<std::uint64_t>(getpid());
    filter.allow(SCMP_SYS(clone), {masked(0, CLONE_THREAD | kNamespaces, CLONE_THREAD)});
    filter.allow(SCMP_SYS(kill), {equals(0, self)});
    filter.allow(SCMP_SYS(tgkill), {equals(0, self)});
    for (const std::uint64_t option : {PR_SET_NAME, PR_GET_NAME, PR_GET_DUMPABLE, PR_SET_VMA})
        filter.allow(SCMP_SYS(prctl), {equals(0, option)});
    for (const std::uint64_t request : {TCGETS, TIOCGWINSZ, FIONREAD, FIONBIO})
        filter.allow(SCMP_SYS(ioctl), {equals(1, request)});
    allowMappings(filter);
}

/// mpirun and what it starts: processes that signal each other (none else, by Landlock's scope where the
/// kernel has it), talk to each other and share memory.
void allowLauncher(Filter& filter) {
    filter.allow(kLauncherCalls);
    filter.allow(kSocketCalls);
    filter.allow(SCMP_SYS(socket), {});
    filter.allow(SCMP_SYS(clone), {masked(0, kNamespaces, 0)});
}

}  // namespace

Status limitCalls(const Rights& rights) {
    Filter filter;
    filter.allow(kProgramCalls);
    allowOpening(filter);
    filter.allow(SCMP_SYS(prlimit64), {equals(0, 0)});  // its own limits, and no other process's
    if (rights.launcher) {
        allowLauncher(filter);
    } else {
        allowOneProcess(filter);
    }
    if (rights.unixSockets && !rights.launcher) {
        filter.allow(kSocketCalls);
        filter.allow(SCMP_SYS(socket), {equals(0, AF_UNIX)});
    }
    return filter.load();
}

}  // namespace mote::server
