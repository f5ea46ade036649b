// SPDX-License-Identifier: GPL-3.0-or-later
//
// ProcessIdentity: one process of this machine since it was switched on, which a process id alone is not (ids
// are used again). A value; its text form is kept by the job store.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {

struct ProcessIdentity {
    int pid = 0;
    std::uint64_t startTime = 0;  ///< clock ticks from boot to its start, /proc/PID/stat field 22
    std::string boot;             ///< /proc/sys/kernel/random/boot_id

    /// The identity of a process that lives (or is not waited for yet). Errors: notFound (there is none),
    /// resourceExhausted, internal (that cannot be known now).
    static Result<ProcessIdentity> of(int pid);
    /// Reads "PID START BOOT".
    static std::optional<ProcessIdentity> parse(std::string_view text);
    std::string toString() const;

    /// A pidfd of just this process. Errors: notFound (it has gone, even if another has its pid by now), as
    /// of().
    Result<storage::FileDescriptor> open() const;

    bool operator==(const ProcessIdentity&) const = default;
};

}  // namespace mote::server
