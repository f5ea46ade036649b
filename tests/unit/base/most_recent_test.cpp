// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/most_recent.h"

#include <gmock/gmock.h>

namespace mote {
namespace {

using testing::ElementsAre;

const auto is = [](int value) { return [value](int other) { return other == value; }; };

TEST(MostRecent, WhatIsUsedComesToTheFront) {
    std::list<int> list{1, 2, 3};
    const int* const found = mostRecent(list, is(3));
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(*found, 3);
    EXPECT_THAT(list, ElementsAre(3, 1, 2));
    EXPECT_EQ(mostRecent(list, is(7)), nullptr);
    EXPECT_THAT(list, ElementsAre(3, 1, 2));
}

TEST(MostRecent, TheOldestGoesWhereThereAreTooMany) {
    std::list<int> list{1, 2};
    EXPECT_EQ(keepMostRecent(list, 3, 5), 5);
    EXPECT_THAT(list, ElementsAre(5, 1, 2));
    keepMostRecent(list, 3, 6);
    EXPECT_THAT(list, ElementsAre(6, 5, 1));
}

TEST(MostRecent, IsMadeOnceWhileItIsKept) {
    std::list<int> list;
    int made = 0;
    const auto use = [&](int value) { return mostRecent(list, 2, is(value), [&] { return ++made, value; }); };
    for (const int value : {1, 2, 1, 3, 1}) EXPECT_EQ(use(value), value);
    EXPECT_EQ(made, 3);
    EXPECT_EQ(use(2), 2);
    EXPECT_EQ(made, 4) << "3 pushed it out";
}

}  // namespace
}  // namespace mote
