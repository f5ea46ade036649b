// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/process_identity.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <sstream>

#include "protocol/base/system_error.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

/// Of a process that is not there, not: what cannot be opened now may be there all the same.
Result<std::string> readLine(const std::string& file) {
    const FileDescriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
    std::array<char, 1024> text{};
    const auto got = opened.valid() ? ::read(opened.get(), text.data(), text.size()) : -1;
    if (got < 0) return systemError(errno == ESRCH ? ENOENT : errno, file, "cannot be read");
    const std::string line(text.data(), static_cast<std::size_t>(got));
    return line.substr(0, line.find('\n'));
}

Result<std::uint64_t> startTimeOf(int pid) {
    const auto file = fmt::format("/proc/{}/stat", pid);
    MOTE_ASSIGN_OR_RETURN(const auto line, readLine(file));
    // The second field is the program's name in parentheses and may hold anything: count from its end.
    const auto name = line.rfind(')');
    std::istringstream fields(name == std::string::npos ? std::string() : line.substr(name + 1));
    std::string field;
    for (int i = 3; i < 22; ++i) fields >> field;
    std::uint64_t ticks = 0;
    if (fields >> ticks) return ticks;
    return Error{ErrorCode::internal, file, "is not what the kernel writes"};
}

}  // namespace

Result<ProcessIdentity> ProcessIdentity::of(int pid) {
    MOTE_ASSIGN_OR_RETURN(const auto start, startTimeOf(pid));
    MOTE_ASSIGN_OR_RETURN(auto boot, readLine("/proc/sys/kernel/random/boot_id"));
    return ProcessIdentity{pid, start, std::move(boot)};
}

std::optional<ProcessIdentity> ProcessIdentity::parse(std::string_view text) {
    ProcessIdentity identity;
    std::istringstream fields{std::string(text)};
    if (!(fields >> identity.pid >> identity.startTime >> identity.boot) || identity.pid <= 1)
        return std::nullopt;
    return identity;
}

std::string ProcessIdentity::toString() const {
    return fmt::format("{} {} {}", pid, startTime, boot);
}

Result<FileDescriptor> ProcessIdentity::open() const {
    FileDescriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
    if (!process.valid())
        return systemError(errno == ESRCH ? ENOENT : errno, std::to_string(pid),
                           "the process cannot be watched");
    // First hold it, then look: what is looked at cannot be replaced any more once it is held and still the
    // same.
    MOTE_ASSIGN_OR_RETURN(const auto found, of(pid));
    if (found == *this) return process;
    return Error{ErrorCode::notFound, std::to_string(pid), "another process has its number by now"};
}

}  // namespace mote::server
