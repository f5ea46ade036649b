// SPDX-License-Identifier: GPL-3.0-or-later
//
// Who follows whom, and what they hear of it.
#include "server/session/following.h"

#include <gmock/gmock.h>

#include <vector>

namespace mote::server {
namespace {

proto::SetView viewOf(std::uint64_t id) {
    proto::SetView view;
    view.set_view_id(id);
    view.set_final_only(true);
    view.set_asked_ns(99);
    return view;
}

class FollowingTest : public testing::Test {
  protected:
    Following::Show show() {
        return [this](const proto::Followed& followed) { shown_.push_back(followed); };
    }
    Following following_;
    std::vector<proto::Followed> shown_;
};

TEST_F(FollowingTest, AViewIsShownAtOnceAndAtEachChange) {
    following_.enter(1, "ann");
    following_.viewChanged(1, viewOf(5));
    ASSERT_TRUE(following_.follow(9, 1, show()).ok());
    following_.viewChanged(1, viewOf(6));
    ASSERT_EQ(shown_.size(), 2u);
    EXPECT_EQ(shown_[0].session(), 1u);
    EXPECT_EQ(shown_[0].client(), "ann");
    EXPECT_EQ(shown_[0].view().view_id(), 5u);
    EXPECT_EQ(shown_[1].view().view_id(), 6u);
    EXPECT_FALSE(shown_[1].view().final_only()) << "a follower sees what comes before the exact picture";
    EXPECT_EQ(shown_[1].view().asked_ns(), 0) << "another's clock";
}

TEST_F(FollowingTest, OthersViewsAreNotShown) {
    following_.enter(1, "ann");
    following_.enter(2, "bob");
    ASSERT_TRUE(following_.follow(9, 1, show()).ok());
    following_.viewChanged(2, viewOf(7));
    ASSERT_EQ(shown_.size(), 1u);
    EXPECT_EQ(shown_[0].session(), 1u);
    EXPECT_FALSE(shown_[0].has_view());
}

TEST_F(FollowingTest, TheLatestIsWhoeverChangedTheirViewLast) {
    following_.enter(1, "ann");
    following_.enter(2, "bob");
    ASSERT_TRUE(following_.follow(9, 0, show()).ok());
    following_.viewChanged(2, viewOf(7));
    following_.viewChanged(1, viewOf(3));
    ASSERT_EQ(shown_.size(), 3u);
    EXPECT_EQ(shown_[0].session(), 0u) << "nobody had a view";
    EXPECT_EQ(shown_[1].session(), 2u);
    EXPECT_EQ(shown_[2].session(), 1u);
}

TEST_F(FollowingTest, NobodyFollowsWhoIsNotThereOrThemselves) {
    following_.enter(1, "ann");
    EXPECT_EQ(following_.follow(9, 2, show()).error().code, ErrorCode::notFound);
    EXPECT_EQ(following_.follow(1, 1, show()).error().code, ErrorCode::notFound);
    EXPECT_TRUE(shown_.empty());
}

TEST_F(FollowingTest, FollowersGoOnWithWhomTheyFollow) {
    following_.enter(1, "ann");
    ASSERT_TRUE(following_.follow(9, 1, show()).ok());
    following_.enter(2, "ann");
    following_.goOn(1, 2);
    following_.leave(1);
    following_.viewChanged(2, viewOf(5));
    ASSERT_EQ(shown_.size(), 2u);
    EXPECT_EQ(shown_[1].session(), 2u);
}

TEST_F(FollowingTest, EndsWithAViewOfOnesOwnOrTheEndOfTheFollower) {
    following_.enter(1, "ann");
    ASSERT_TRUE(following_.follow(8, 1, show()).ok());
    ASSERT_TRUE(following_.follow(9, 1, show()).ok());
    following_.unfollow(8);
    following_.leave(9);
    following_.viewChanged(1, viewOf(5));
    EXPECT_EQ(shown_.size(), 2u);
}

TEST_F(FollowingTest, TheListSaysWhoElseIsThere) {
    following_.enter(1, "ann");
    following_.enter(2, "bob");
    following_.viewChanged(2, viewOf(7));
    const auto all = following_.list(9), others = following_.list(1);
    EXPECT_EQ(all.sessions_size(), 2);
    ASSERT_EQ(others.sessions_size(), 1);
    EXPECT_EQ(others.sessions(0).session(), 2u);
    EXPECT_EQ(others.sessions(0).client(), "bob");
    EXPECT_TRUE(others.sessions(0).has_view());
}

}  // namespace
}  // namespace mote::server
