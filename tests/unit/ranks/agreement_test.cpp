// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/agreement.h"

#include <gtest/gtest.h>

#include <functional>
#include <new>
#include <stdexcept>
#include <thread>

#include "tests/support/rank_crew.h"

namespace mote::render {
namespace {

class AgreementTest : public testing::Test {
  protected:
    /// Two ranks do their work and agree; what rank 0 knows then.
    void agree(const std::function<void()>& first, const std::function<void()>& second) {
        std::thread other([&] {
            Agreement agreement(ranks_[1]);
            agreement.attempt(second);
            otherGoesOn_ = agreement.all({});
        });
        Agreement agreement(ranks_[0]);
        agreement.attempt(first);
        goesOn_ = agreement.all({});
        other.join();
        failure_ = agreement.failure();
    }

    test::ThreadRanks ranks_{2};
    bool goesOn_ = false, otherGoesOn_ = false;
    std::optional<Error> failure_;
};

TEST_F(AgreementTest, WhereAllIsWellTheyGoOn) {
    agree([] {}, [] {});
    EXPECT_TRUE(goesOn_ && otherGoesOn_);
    EXPECT_FALSE(failure_);
}

TEST_F(AgreementTest, AFailureIsToldAndNamesItsRank) {
    agree([] {}, [] { throw std::runtime_error("the disk is gone"); });
    EXPECT_FALSE(goesOn_ || otherGoesOn_);
    ASSERT_TRUE(failure_);
    EXPECT_EQ(failure_->toString(), "view: rank 1: the disk is gone");
}

TEST_F(AgreementTest, WhatThereIsNoMemoryForIsAFailureInASentence) {
    agree([] {}, [] { throw std::bad_alloc(); });
    EXPECT_FALSE(goesOn_ || otherGoesOn_);
    ASSERT_TRUE(failure_);
    EXPECT_EQ(failure_->toString(), "view: rank 1: there is not enough memory to draw it");
}

}  // namespace
}  // namespace mote::render
