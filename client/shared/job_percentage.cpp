// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/job_percentage.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

#include "protocol/scene/utf8.h"

namespace mote::client {
namespace {

constexpr const char* wipe = "\r\x1b[K";

}  // namespace

JobPercentage::JobPercentage(std::string what, bool wanted)
    : what_(std::move(what)), visible_(wanted && ::isatty(STDERR_FILENO) == 1) {}

JobPercentage::~JobPercentage() {
    if (shown_) std::fputs(wipe, stderr);
}

void JobPercentage::show(const proto::JobStatus& job) {
    if (!visible_) return;
    fmt::print(stderr, "{}{}: {:.0f}% {}", wipe, what_, 100.0 * job.progress(), toTerminalText(job.phase()));
    std::fflush(stderr);
    shown_ = true;
}

}  // namespace mote::client
