// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

#include "protocol/base/system_error.h"
#include "server/jobs/supervise/supervise.h"
#include "storage/files/real_path.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

// Of later versions of Landlock than the headers of this system may know.
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14;     // version 3
constexpr std::uint64_t kDeviceIoctl = std::uint64_t{1} << 15;  // version 5
constexpr std::uint64_t kTcp = 3;                               // version 4: bind, connect
constexpr std::uint64_t kAbstractSocketsAndSignals = 3;         // version 6

/// landlock_ruleset_attr as of version 6; earlier ones end sooner.
struct Handled {
    std::uint64_t files = 0;
    std::uint64_t network = 0;
    std::uint64_t scoped = 0;
};

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kExecute = kRead | LANDLOCK_ACCESS_FS_EXECUTE;
constexpr std::uint64_t kFile =  // what may be allowed of a file that is no folder
    LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_EXECUTE | kTruncate;
constexpr std::uint64_t kNeverWritten = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                                        LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SOCK |
                                        kDeviceIoctl;

std::uint64_t knownFileRights(long version) {
    std::uint64_t rights = (std::uint64_t{1} << 13) - 1;
    if (version >= 2) rights |= LANDLOCK_ACCESS_FS_REFER;
    if (version >= 3) rights |= kTruncate;
    if (version >= 5) rights |= kDeviceIoctl;
    return rights;
}

/// Everything that this kernel's Landlock can take away, but for what a launcher's processes share.
Handled handledBy(long version, const Rights& rights) {
    Handled handled;
    handled.files = knownFileRights(version);
    if (version >= 4 && !rights.launcher) handled.network = kTcp;
    if (version >= 6) handled.scoped = kAbstractSocketsAndSignals;
    return handled;
}

std::size_t sizeOfHandled(long version) {
    return sizeof(std::uint64_t) * (version >= 6 ? 3 : version >= 4 ? 2 : 1);
}

Status allow(int rules, const FileDescriptor& place, const std::filesystem::path& path,
             std::uint64_t rights) {
    struct stat kind {};
    if (!place.valid() || fstat(place.get(), &kind) != 0) return success();  // nothing there to allow
    landlock_path_beneath_attr rule{};
    rule.allowed_access = S_ISDIR(kind.st_mode) ? rights : rights & kFile;
    rule.parent_fd = place.get();
    if (syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0) return success();
    return failedCall(path.c_str());
}

Status allowAll(int rules, const std::vector<std::filesystem::path>& paths, std::uint64_t rights) {
    for (const auto& path : paths) {
        const FileDescriptor place(open(path.c_str(), O_PATH | O_CLOEXEC));
        MOTE_RETURN_IF_ERROR(allow(rules, place, path, rights));
    }
    return success();
}

/// These were looked up before, and lie where others may write: a link in their place is not followed.
Status allowWriting(int rules, const std::vector<std::filesystem::path>& paths, std::uint64_t rights) {
    for (const auto& path : paths) {
        MOTE_ASSIGN_OR_RETURN(const auto place, storage::openReal(path, O_PATH));
        MOTE_RETURN_IF_ERROR(allow(rules, place, path, rights));
    }
    return success();
}

}  // namespace

long landlockVersion() {
    return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
}

Status limitFiles(const Rights& rights) {
    const long version = landlockVersion();
    if (version < 1) return Error{ErrorCode::unsupported, "", "this kernel has no Landlock"};
    const auto handled = handledBy(version, rights);
    const FileDescriptor rules(
        static_cast<int>(syscall(SYS_landlock_create_ruleset, &handled, sizeOfHandled(version), 0)));
    if (!rules.valid()) return failedCall("landlock_create_ruleset");
    MOTE_RETURN_IF_ERROR(allowAll(rules.get(), rights.readable, kRead));
    MOTE_RETURN_IF_ERROR(allowAll(rules.get(), rights.executable, kExecute));
    MOTE_RETURN_IF_ERROR(allowWriting(rules.get(), rights.writable, handled.files & ~kNeverWritten));
    if (syscall(SYS_landlock_restrict_self, rules.get(), 0) == 0) return success();
    return failedCall("landlock_restrict_self");
}

}  // namespace mote::server
