// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/crash_record.h"

#include <gtest/gtest.h>

#include "protocol/wire/framing.h"

namespace mote::server {
namespace {

TEST(CrashRecord, BlamesTheViewThatIsDrawn) {
    CrashRecord record;
    EXPECT_FALSE(record.view());
    record.begin("one");
    EXPECT_EQ(record.view(), "one");
    record.begin("another");
    EXPECT_EQ(record.view(), "another");
    record.end();
    EXPECT_FALSE(record.view());
}

TEST(CrashRecord, CountsTheDeathsOfEachView) {
    CrashRecord record;
    EXPECT_EQ(record.deaths("one"), 0u);
    EXPECT_EQ(record.count("one"), 1u);
    EXPECT_EQ(record.count("other"), 1u);
    EXPECT_EQ(record.count("one"), 2u);
    EXPECT_EQ(record.deaths("one"), 2u);
    EXPECT_EQ(record.deaths("none"), 0u);
}

TEST(CrashRecord, IsClearedForTheNextProcessButForCountsAndCosts) {
    CrashRecord record;
    record.ready();
    record.begin("one");
    record.count("one");
    EXPECT_FALSE(record.costs());
    record.learn({.millionPoints = 3.0, .millionPixels = 4.0});
    EXPECT_TRUE(record.wasReady());
    record.clear();
    EXPECT_FALSE(record.wasReady());
    EXPECT_FALSE(record.view());
    EXPECT_EQ(record.deaths("one"), 1u);
    ASSERT_TRUE(record.costs());
    EXPECT_EQ(record.costs()->millionPixels, 4.0);
}

TEST(CrashRecord, HoldsTheLongestMessageAndNoMore) {
    CrashRecord record;
    const std::string longest(wire::clientLimits.message, 'x');
    record.begin(longest + "y");
    EXPECT_EQ(record.view(), longest);
}

TEST(CrashRecord, RemembersAFewHundredViews) {
    CrashRecord record;
    for (int i = 0; i < 1000; ++i) record.count(std::to_string(i));
    record.count("last");
    EXPECT_EQ(record.count("last"), 2u);
}

}  // namespace
}  // namespace mote::server
