// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>

#include "protocol/scene/system_error.h"
#include "server/jobs/supervise/rights.h"

namespace mote::server {
namespace {

constexpr int kNiceness = 5;                                 // rendering comes first
constexpr std::uint64_t kHeadroom = std::uint64_t{1} << 29;  // libraries, stacks of threads

Status lower(int resource, std::uint64_t value) {
    rlimit limit{};
    getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
    limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(value, limit.rlim_max);
    if (setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) == 0) return success();
    return Error{ErrorCode::internal, "setrlimit", systemMessage(errno)};
}

}  // namespace

Status limitResources(const Rights& rights) {
    MOTE_RETURN_IF_ERROR(lower(RLIMIT_CORE, 0));
    // RLIMIT_DATA and not RLIMIT_AS: mapped files are no memory that anyone else misses.
    if (rights.memory != 0) MOTE_RETURN_IF_ERROR(lower(RLIMIT_DATA, rights.memory + kHeadroom));
    setpriority(PRIO_PROCESS, 0, std::min(19, getpriority(PRIO_PROCESS, 0) + kNiceness));
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0) return success();
    return Error{ErrorCode::internal, "no_new_privs", systemMessage(errno)};
}

}  // namespace mote::server
