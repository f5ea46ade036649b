// SPDX-License-Identifier: GPL-3.0-or-later
//
// Wakeup: a condition variable for coroutines of one thread. A coroutine waits in a loop that asks for what
// it waits for; notify() wakes all that wait now. Nothing is lost, as nobody else runs between asking and
// waiting.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/awaitable.hpp>
#include <asio/experimental/as_tuple.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

namespace mote::server {

class Wakeup {
  public:
    explicit Wakeup(const asio::any_io_executor& executor)
        : timer_(executor, asio::steady_timer::time_point::max()) {}

    void notify() { timer_.cancel(); }
    asio::awaitable<void> wait() {
        co_await timer_.async_wait(asio::experimental::as_tuple(asio::use_awaitable));
    }

  private:
    asio::steady_timer timer_;
};

}  // namespace mote::server
