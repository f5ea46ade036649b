// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/run_through.h"

#include <gtest/gtest.h>

#include <asio/post.hpp>
#include <new>

namespace mote::server {
namespace {

bool never() {
    return false;
}

TEST(RunThrough, WhatAHandlerThrowsIsLostAndNoMore) {
    asio::io_context io;
    int prepared = 0, done = 0;
    for (int i = 0; i < 3; ++i) {
        asio::post(io, [] { throw std::bad_alloc(); });
        asio::post(io, [&] { ++done; });
    }
    runThrough(
        io, [&] { ++prepared; }, never);
    EXPECT_EQ(done, 3);
    EXPECT_EQ(prepared, 4) << "what threw may have been about to begin something";
}

TEST(RunThrough, WhatCannotBeBegunIsTriedAgain) {
    asio::io_context io;
    int tries = 0;
    bool begun = false;
    const auto prepare = [&] {
        if (++tries < 3) throw std::bad_alloc();
        asio::post(io, [&] { begun = true; });
    };
    runThrough(io, prepare, never);
    EXPECT_TRUE(begun);
}

TEST(RunThrough, ItEndsWhereThatIsOfNoUse) {
    asio::io_context io;
    int tries = 0;
    runThrough(
        io,
        [&] {
            ++tries;
            throw std::bad_alloc();
        },
        [&] { return tries == 3; });
    EXPECT_EQ(tries, 3);
}

TEST(RunThrough, AStopEndsIt) {
    asio::io_context io;
    const auto kept = asio::make_work_guard(io);
    asio::post(io, [&] { io.stop(); });
    runThrough(
        io, [] {}, never);
    EXPECT_TRUE(io.stopped());
}

}  // namespace
}  // namespace mote::server
