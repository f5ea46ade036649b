// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/address.h"

#include <gtest/gtest.h>

namespace mote::wire {
namespace {

TEST(Address, GoodOnesGoThereAndBack) {
    for (const char* text : {"unix:/run/user/1000/mote.sock", "unix:relative", "tcp:localhost:0",
                             "tcp:127.0.0.1:65535", "tcp:[::1]:80"}) {
        const auto address = parseAddress(text);
        ASSERT_TRUE(address.ok()) << text;
        EXPECT_EQ(address->toString(), text);
    }
    EXPECT_EQ(parseAddress("tcp:[::1]:80")->host, "::1");
    EXPECT_EQ(parseAddress("tcp:[::1]:80")->port, 80);
}

TEST(Address, BadOnesAreRefused) {
    using namespace std::string_view_literals;
    for (const std::string_view text :
         {""sv, "unix"sv, "unix:"sv, "unix:a\0b"sv, "udp:host:1"sv, "tcp:"sv, "tcp:host"sv, "tcp:host:"sv,
          "tcp::80"sv, "tcp:host:65536"sv, "tcp:host:-1"sv, "tcp:host:8x"sv, "tcp:::1:80"sv, "/socket"sv}) {
        const auto address = parseAddress(text);
        ASSERT_FALSE(address.ok()) << text;
        EXPECT_EQ(address.error().code, ErrorCode::invalidArgument);
    }
}

TEST(Address, PathThatTheKernelCannotHoldIsRefused) {
    const std::string longest = "unix:/" + std::string(maxSocketPath - 1, 'x');
    EXPECT_TRUE(parseAddress(longest).ok());
    EXPECT_FALSE(parseAddress(longest + "x").ok());
}

}  // namespace
}  // namespace mote::wire
