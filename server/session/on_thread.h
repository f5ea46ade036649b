// SPDX-License-Identifier: GPL-3.0-or-later
//
// onThread: how a coroutine asks another thread and waits for the answer, whoever works there.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/async_result.hpp>
#include <asio/post.hpp>
#include <asio/use_awaitable.hpp>
#include <memory>
#include <utility>

namespace mote::server {

/// Calls ask(answered) and goes on with the answer, on the one thread of `home`: as what was posted there
/// when it came, so that what that thread posts later is newer. `answered` is a function that may be copied,
/// called once on any thread; where it is given up before, what waits is destroyed with it, which must be
/// done on home's thread.
template <class Answer, class Ask>
asio::awaitable<Answer> onThread(asio::any_io_executor home, Ask ask) {
    return asio::async_initiate<const asio::use_awaitable_t<>, void(Answer)>(
        [home = std::move(home)](auto waiting, Ask question) {
            const auto shared = std::make_shared<decltype(waiting)>(std::move(waiting));
            question([home, shared](Answer answer) {
                asio::post(home, [shared, answer = std::move(answer)]() mutable {
                    std::move (*shared)(std::move(answer));
                });
            });
        },
        asio::use_awaitable, std::move(ask));
}

}  // namespace mote::server
