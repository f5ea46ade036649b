// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <cerrno>

#include "protocol/scene/system_error.h"
#include "server/jobs/supervise/rights.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

// Landlock's ABI 3 has it; the headers of this system may not know it yet.
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14;

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kExecute = kRead | LANDLOCK_ACCESS_FS_EXECUTE;
constexpr std::uint64_t kFile =  // what may be allowed of a file that is no folder
    LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_EXECUTE | kTruncate;

/// Every right over files that this kernel's Landlock knows; 0: it has none.
std::uint64_t knownRights() {
    const long abi = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (abi < 1) return 0;
    std::uint64_t rights = (std::uint64_t{1} << 13) - 1;
    if (abi >= 2) rights |= LANDLOCK_ACCESS_FS_REFER;
    if (abi >= 3) rights |= kTruncate;
    return rights;
}

Error failure(const char* what) {
    return {ErrorCode::internal, what, systemMessage(errno)};
}

Status allow(int rules, const std::filesystem::path& path, std::uint64_t rights) {
    const FileDescriptor folder(open(path.c_str(), O_PATH | O_CLOEXEC));
    struct stat kind {};
    if (!folder.valid() || fstat(folder.get(), &kind) != 0) return success();  // nothing there to allow
    landlock_path_beneath_attr rule{};
    rule.allowed_access = S_ISDIR(kind.st_mode) ? rights : rights & kFile;
    rule.parent_fd = folder.get();
    if (syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0) return success();
    return failure(path.c_str());
}

}  // namespace

Status limitFiles(const Rights& rights) {
    const auto known = knownRights();
    if (known == 0) return Error{ErrorCode::unsupported, "", "this kernel has no Landlock"};
    landlock_ruleset_attr attributes{};
    attributes.handled_access_fs = known;
    const FileDescriptor rules(static_cast<int>(
        syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes.handled_access_fs, 0)));
    if (!rules.valid()) return failure("landlock_create_ruleset");
    for (const auto& path : rights.readable) MOTE_RETURN_IF_ERROR(allow(rules.get(), path, kRead));
    for (const auto& path : rights.executable) MOTE_RETURN_IF_ERROR(allow(rules.get(), path, kExecute));
    const auto all = known & ~std::uint64_t{LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                                            LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SOCK};
    for (const auto& path : rights.writable) MOTE_RETURN_IF_ERROR(allow(rules.get(), path, all));
    if (syscall(SYS_landlock_restrict_self, rules.get(), 0) == 0) return success();
    return failure("landlock_restrict_self");
}

}  // namespace mote::server
