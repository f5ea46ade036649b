// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/process_identity.h"

#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace mote::server {
namespace {

std::string bootId() {
    std::string id;
    std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
    return id;
}

std::optional<std::uint64_t> startTimeOf(int pid) {
    std::string line;
    if (!std::getline(std::ifstream(fmt::format("/proc/{}/stat", pid)), line)) return std::nullopt;
    // The second field is the program's name in parentheses and may hold anything: count from its end.
    const auto name = line.rfind(')');
    if (name == std::string::npos) return std::nullopt;
    std::istringstream fields(line.substr(name + 1));
    std::string field;
    for (int i = 3; i < 22; ++i) fields >> field;
    std::uint64_t ticks = 0;
    return fields >> ticks ? std::optional(ticks) : std::nullopt;
}

}  // namespace

std::optional<ProcessIdentity> ProcessIdentity::of(int pid) {
    const auto start = startTimeOf(pid);
    if (!start) return std::nullopt;
    return ProcessIdentity{pid, *start, bootId()};
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

storage::FileDescriptor ProcessIdentity::open() const {
    storage::FileDescriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
    // First hold it, then look: what is looked at cannot be replaced any more once it is held and still the
    // same.
    if (!process.valid() || of(pid) != *this) return {};
    return process;
}

}  // namespace mote::server
