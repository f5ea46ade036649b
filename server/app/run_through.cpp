// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/run_through.h"

#include <chrono>
#include <exception>
#include <thread>

#include "server/log.h"

namespace mote::server {

void runThrough(asio::io_context& io, const std::function<void()>& prepare,
                const std::function<bool()>& over) {
    // Memory comes back by waiting, not by asking at once again.
    constexpr std::chrono::milliseconds pause(10);
    for (;;) {
        try {
            prepare();
            io.run();
            return;
        } catch (const std::exception& failure) {
            log::failure("something was left undone", failure);
            if (over()) return;
            std::this_thread::sleep_for(pause);
        }
    }
}

}  // namespace mote::server
