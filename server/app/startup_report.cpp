// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/startup_report.h"

#include <fmt/format.h>
#include <linux/seccomp.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <filesystem>

#include "server/log.h"

namespace mote::server {
namespace {

// <linux/landlock.h> of older systems does not have them.
constexpr unsigned askLandlockVersion = 1;
constexpr long landlockCreateRuleset = 444;

std::string freeSpace(const std::filesystem::path& folder) {
    std::error_code code;
    const auto space = std::filesystem::space(folder, code);
    return code ? code.message() : fmt::format("{} MiB free", space.available >> 20);
}

void reportPrograms(const ServerSettings& settings) {
    for (const auto& [what, program] : {std::pair("jobs", settings.prep), {"films", settings.frames}}) {
        if (::access(program.c_str(), X_OK) == 0) {
            log::info("{} run {}", what, program.string());
        } else {
            log::warn("there will be no {}: {} is no program", what, program.string());
        }
    }
}

void reportKernel() {
    struct utsname system {};
    ::uname(&system);
    const auto features = kernelFeatures();
    if (features.landlock > 0) {
        log::info("kernel {}: jobs are confined by Landlock (ABI {})", system.release, features.landlock);
    } else {
        log::warn("kernel {}: there is no Landlock to confine jobs", system.release);
    }
    if (features.seccomp) {
        log::info("kernel {}: system calls of jobs are filtered (seccomp)", system.release);
    } else {
        log::warn("kernel {}: there is no seccomp to filter system calls of jobs", system.release);
    }
}

}  // namespace

KernelFeatures kernelFeatures() {
    KernelFeatures features;
    const long version = ::syscall(landlockCreateRuleset, nullptr, 0, askLandlockVersion);
    features.landlock = version > 0 ? static_cast<int>(version) : 0;
    const unsigned action = SECCOMP_RET_ERRNO;
    features.seccomp = ::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
    return features;
}

void reportStart(const ServerSettings& settings, const std::string& device) {
    log::info("mote-server " MOTE_VERSION ", process {}, draws with {}", ::getpid(), device);
    log::info("state in {}: {}", settings.stateDirectory.string(), freeSpace(settings.stateDirectory));
    for (const auto& root : settings.roots) {
        const auto folder = root.substr(std::min(root.size(), root.find('=') + 1));
        const bool writable = ::access(folder.c_str(), W_OK) == 0;
        log::info("root {}: {}{}", root, freeSpace(folder), writable ? "" : ", read only: no jobs into it");
    }
    reportPrograms(settings);
    reportKernel();
}

}  // namespace mote::server
