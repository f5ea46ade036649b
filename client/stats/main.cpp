// SPDX-License-Identifier: GPL-3.0-or-later

#include <cstdio>
#include <exception>

#include "client/shared/interrupt.h"
#include "client/stats/options.h"
#include "client/stats/stats_run.h"
#include "protocol/scene/complain.h"

namespace mote::client {
namespace {

constexpr int failure = 1;
constexpr int killedBy = 128;  // and the signal's number, as shells say it

int run(int argc, const char* const* argv) {
    const Interrupt interrupt;
    const auto parsed = parseStatsOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    const auto done = runStats(std::get<StatsOptions>(parsed), interrupt);
    if (done.ok()) return 0;
    complain("mote-stats", done.error().toString());
    return interrupt.requested() ? killedBy + interrupt.signal() : failure;
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    try {
        return mote::client::run(argc, argv);
    } catch (const std::exception& error) {
        mote::complainAtEnd("mote-stats", error);
        return 1;
    }
}
