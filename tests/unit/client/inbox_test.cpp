// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/connection_parts.h"

#include <gtest/gtest.h>

namespace mote::client {
namespace {

std::string heard(Inbox& inbox, std::string& log) {
    for (auto& entry : inbox.takeAll()) entry.callback();
    return std::exchange(log, {});
}

TEST(InboxTest, NewerNewsOfAStateTakesTheOldersPlaceAtTheEnd) {
    Inbox inbox;
    std::string log;
    const auto say = [&](const char* word) { return [&log, word] { log += word; }; };
    inbox.push("job 1", say("a"));
    inbox.push("", say("b"));
    inbox.push("job 2", say("c"));
    inbox.push("job 1", say("d"));
    inbox.push("", say("e"));
    EXPECT_EQ(heard(inbox, log), "bcde");
    EXPECT_TRUE(inbox.empty());
    EXPECT_EQ(heard(inbox, log), "");
}

TEST(SlidingRateTest, CountsTheLastTwoSecondsOnly) {
    SlidingRate rate;
    const SlidingRate::Time start{};
    const auto at = [&](int ms) { return start + std::chrono::milliseconds(ms); };
    EXPECT_EQ(rate.perSecond(at(0)), 0.0);
    rate.add(at(0), 4.0);
    rate.add(at(0), 2.0);
    rate.add(at(1000), 2.0);
    EXPECT_EQ(rate.perSecond(at(1500)), 4.0);
    EXPECT_EQ(rate.perSecond(at(2500)), 1.0);
    EXPECT_EQ(rate.perSecond(at(3001)), 0.0);
}

}  // namespace
}  // namespace mote::client
