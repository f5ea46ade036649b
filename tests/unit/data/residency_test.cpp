// SPDX-License-Identifier: GPL-3.0-or-later
//
// Residency by things that cost nothing: what is counted, what goes for what, and what is said of failures.
// hybrid_residency_test.cpp has the order in which a series comes.
#include "server/data/residency.h"

#include <gmock/gmock.h>

#include <condition_variable>
#include <future>
#include <new>
#include <set>
#include <stdexcept>
#include <thread>

namespace mote::server {
namespace {

using Entry = storage::Catalogue::Entry;
using testing::ElementsAre;
using testing::IsEmpty;

struct Thing {
    std::uint64_t size;
    std::uint64_t bytes() const { return size; }
};
struct OtherThing : Thing {};

Entry entryOf(const std::string& name) {
    return {name, "/nowhere/" + name, std::make_shared<const proto::Manifest>()};
}

class ResidencyTest : public testing::Test {
  protected:
    ~ResidencyTest() override { openGate(true); }

    void start(std::uint64_t bytes, unsigned threads = 1) {
        budget_ = std::make_shared<storage::BlockBudget>(bytes);
        residency_ = std::make_unique<Residency>(budget_, threads, [this] {
            const std::lock_guard lock(mutex_);
            changed_.notify_all();
        });
    }
    /// Loads wait for it.
    void openGate(bool open) {
        const std::lock_guard lock(mutex_);
        open_ = open;
        changed_.notify_all();
    }
    void await(const std::function<bool()>& reached) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, reached);
    }
    void awaitRest() {
        await([this] { return residency_->underWay() == 0; });
    }
    /// A thing of `size` bytes that is thought to take `expected` of them.
    template <class T = Thing>
    Loadable<T> thing(const Entry& entry, std::uint64_t expected = 10, std::uint64_t size = 10) {
        return {entry, [=](std::uint32_t) { return expected; },
                [this, size](std::uint32_t step, const AnyLoadable::Cancelled& cancelled) {
                    return load<T>(size, step, cancelled);
                }};
    }
    std::shared_ptr<const void> get(const AnyLoadable& what) {
        const auto found = residency_->get(what);
        EXPECT_TRUE(found.ok()) << found.error().toString();
        return found.ok() ? found->value : nullptr;
    }
    /// The picture after, which asks for it until it is there.
    std::shared_ptr<const void> bring(const AnyLoadable& what) {
        budget_->beginGeneration();
        if (auto there = get(what)) return there;
        awaitRest();
        return get(what);
    }

    const Entry a_ = entryOf("a"), b_ = entryOf("b"), c_ = entryOf("c"), d_ = entryOf("d");
    std::mutex mutex_;
    std::condition_variable changed_;
    // Under the mutex.
    bool open_ = true;
    std::vector<std::uint32_t> loaded_;  // steps, in their order
    std::set<std::thread::id> threads_;  // that loaded
    std::function<void()> fail_;         // throws
    std::optional<Error> error_;
    bool cancelled_ = false;

    std::shared_ptr<storage::BlockBudget> budget_;
    std::unique_ptr<Residency> residency_;

  private:
    template <class T>
    Result<std::shared_ptr<const T>> load(std::uint64_t size, std::uint32_t step,
                                          const AnyLoadable::Cancelled& cancelled) {
        std::unique_lock lock(mutex_);
        loaded_.push_back(step);
        threads_.insert(std::this_thread::get_id());
        changed_.notify_all();
        while (!open_ && !cancelled()) changed_.wait_for(lock, std::chrono::milliseconds(1));
        cancelled_ = cancelled();
        if (cancelled_) return Error{ErrorCode::cancelled, "", "on request"};
        if (fail_) fail_();
        if (error_) return *error_;
        return std::make_shared<const T>(T{size});
    }
};

TEST_F(ResidencyTest, LoadedStepsAreThoseWithAllTheirParts) {
    start(100);
    const auto bringPart = [&](std::uint32_t step, int part) {
        auto what = thing(a_);
        what.step = step;
        what.steps = 9;
        what.part = part;
        ASSERT_NE(bring(what), nullptr);
    };
    EXPECT_THAT(residency_->loadedSteps(a_), IsEmpty());
    bringPart(4, 0);
    bringPart(7, 0);
    EXPECT_THAT(residency_->loadedSteps(a_), ElementsAre(4U, 7U));
    bringPart(7, 1);
    EXPECT_THAT(residency_->loadedSteps(a_), ElementsAre(7U));
    EXPECT_THAT(residency_->loadedSteps(b_), IsEmpty());
}

TEST_F(ResidencyTest, WhatIsAskedForIsLoadedByAnotherThread) {
    start(100);
    openGate(false);
    EXPECT_EQ(get(thing(a_)), nullptr);
    await([this] { return !loaded_.empty(); });
    EXPECT_EQ(get(thing(a_)), nullptr) << "still on its way";
    openGate(true);
    awaitRest();
    const auto there = get(thing(a_));
    ASSERT_NE(there, nullptr);
    EXPECT_EQ(get(thing(a_)), there);
    EXPECT_EQ(loaded_.size(), 1U);
    EXPECT_FALSE(threads_.contains(std::this_thread::get_id()));
}

TEST_F(ResidencyTest, TheEstimateIsCountedWhileItIsLoadedAndTheExactNumberAfter) {
    start(100);
    for (const std::uint64_t size : {4U, 15U}) {
        const auto entry = entryOf("one");
        const auto before = budget_->resident();
        openGate(false);
        const auto begun = loaded_.size();
        get(thing(entry, 10, size));
        await([&] { return loaded_.size() > begun; });
        EXPECT_EQ(budget_->resident(), before + 10);
        openGate(true);
        awaitRest();
        EXPECT_NE(get(thing(entry, 10, size)), nullptr);
        EXPECT_EQ(budget_->resident(), before + size);
    }
    residency_.reset();
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(ResidencyTest, WhatWasUsedLongestAgoGoesForWhatComes) {
    start(30);
    for (const auto& entry : {a_, b_, c_, a_, d_}) ASSERT_NE(bring(thing(entry)), nullptr) << entry.name;
    EXPECT_EQ(residency_->loaded(), 3U);
    EXPECT_EQ(budget_->resident(), 30U);
    EXPECT_NE(get(thing(a_)), nullptr);
    EXPECT_NE(get(thing(c_)), nullptr);
    EXPECT_EQ(get(thing(b_)), nullptr) << "the oldest";
}

TEST_F(ResidencyTest, WhatThePresentPictureUsesStaysAndTheRestIsSaidToBeTooMuch) {
    start(15);
    ASSERT_NE(bring(thing(a_)), nullptr);
    EXPECT_EQ(get(thing(b_)), nullptr);
    awaitRest();
    budget_->beginGeneration();
    EXPECT_NE(get(thing(a_)), nullptr);
    const auto refused = residency_->get(thing(b_));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);
    EXPECT_NE(get(thing(a_)), nullptr);
    EXPECT_EQ(budget_->resident(), 10U);
    // A picture of the other alone has room.
    EXPECT_NE(bring(thing(b_)), nullptr);
}

TEST_F(ResidencyTest, WhatIsStillHeldCountsAndOthersGoForIt) {
    start(30);
    auto held = bring(thing(a_));
    for (const auto& entry : {b_, c_, d_}) ASSERT_NE(bring(thing(entry)), nullptr) << entry.name;
    EXPECT_EQ(residency_->loaded(), 2U) << "the second oldest went as well";
    EXPECT_EQ(budget_->resident(), 30U);
    held.reset();
    EXPECT_EQ(budget_->resident(), 20U);
}

TEST_F(ResidencyTest, NobodyIsRefusedForWhatOthersHold) {
    start(15);
    auto held = bring(thing(a_));
    EXPECT_NE(bring(thing(b_)), nullptr);
    EXPECT_EQ(budget_->resident(), 20U) << "what is there is counted";
    residency_.reset();
    EXPECT_EQ(budget_->resident(), 10U);
    held.reset();
    EXPECT_EQ(budget_->resident(), 0U);
    EXPECT_FALSE(budget_->take(16, budget_->generation())) << "nothing is passed over any more";
}

TEST_F(ResidencyTest, WhatTurnsOutToBeTooMuchIsGivenUp) {
    start(15);
    EXPECT_EQ(get(thing(a_, 10, 20)), nullptr);
    awaitRest();
    EXPECT_EQ(residency_->get(thing(a_, 10, 20)).error().code, ErrorCode::resourceExhausted);
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(ResidencyTest, AnErrorIsSaidOnceAndThenItIsTriedAnew) {
    start(100);
    error_ = Error{ErrorCode::corrupt, "a/file", "is damaged"};
    EXPECT_EQ(get(thing(a_)), nullptr);
    awaitRest();
    const auto failed = residency_->get(thing(a_));
    ASSERT_FALSE(failed.ok());
    EXPECT_EQ(failed.error().where, "a/file");
    EXPECT_EQ(budget_->resident(), 0U);
    {
        const std::lock_guard lock(mutex_);
        error_.reset();
    }
    EXPECT_EQ(get(thing(a_)), nullptr);
    awaitRest();
    EXPECT_NE(get(thing(a_)), nullptr);
}

TEST_F(ResidencyTest, WhatIsThrownIsAnError) {
    start(100);
    fail_ = [] { throw std::runtime_error("the disk is gone"); };
    get(thing(a_));
    awaitRest();
    const auto failed = residency_->get(thing(a_));
    ASSERT_FALSE(failed.ok());
    EXPECT_EQ(failed.error().code, ErrorCode::internal);
    EXPECT_EQ(failed.error().message, "the disk is gone");
    fail_ = [] { throw std::bad_alloc(); };
    get(thing(b_));
    awaitRest();
    EXPECT_EQ(residency_->get(thing(b_)).error().code, ErrorCode::resourceExhausted);
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(ResidencyTest, ItsEndCancelsWhatIsUnderWay) {
    start(100);
    openGate(false);
    get(thing(a_));
    get(thing(b_));
    await([this] { return !loaded_.empty(); });
    residency_.reset();
    EXPECT_TRUE(cancelled_);
    EXPECT_EQ(loaded_.size(), 1U) << "what was in line is not begun";
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(ResidencyTest, TheNextStepsOfASeriesAreLoadedAhead) {
    start(1000);
    auto step = thing(a_);
    step.steps = 16;
    for (step.step = 3; step.step < 5; ++step.step) {
        get(step);
        awaitRest();
    }
    EXPECT_THAT(loaded_, ElementsAre(3, 4, 5, 6, 7, 8));
    EXPECT_TRUE(residency_->played(a_));
    EXPECT_FALSE(residency_->played(b_));
    auto alone = thing(b_);
    for (alone.step = 0; alone.step < 2; ++alone.step) get(alone);
    awaitRest();
    EXPECT_EQ(residency_->loaded(), 8U) << "it is no series";
}

TEST_F(ResidencyTest, ThreadsThatAskAtOnceShareOne) {
    start(100, 3);
    std::vector<std::future<std::shared_ptr<const void>>> asked;
    for (int i = 0; i < 4; ++i) {
        asked.push_back(std::async(std::launch::async, [&] {
            for (;;) {
                if (auto there = get(thing(a_))) return there;
                awaitRest();
            }
        }));
    }
    std::set<std::shared_ptr<const void>> found;
    for (auto& one : asked) found.insert(one.get());
    EXPECT_EQ(found.size(), 1U);
    EXPECT_EQ(loaded_.size(), 1U);
    EXPECT_EQ(budget_->resident(), 10U);
}

TEST_F(ResidencyTest, TypesPartsAndLaterDatasetsOfANameAreToldApart) {
    start(100);
    const auto first = bring(thing(a_));
    EXPECT_NE(bring(thing<OtherThing>(a_)), first);
    auto part = thing(a_);
    part.part = 1;
    EXPECT_NE(bring(part), first);
    EXPECT_NE(bring(thing(entryOf("a"))), first);
    EXPECT_EQ(get(thing(a_)), first);
    EXPECT_EQ(budget_->resident(), 40U);
}

TEST_F(ResidencyTest, MoreThingsThanItKeepsPushTheOldestOut) {
    start(10000);
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < Residency::most + 3; ++i) {
        entries.push_back(entryOf(std::to_string(i)));
        ASSERT_NE(bring(thing(entries.back())), nullptr);
    }
    EXPECT_EQ(residency_->loaded(), Residency::most);
    EXPECT_EQ(budget_->resident(), 10 * Residency::most);
    EXPECT_EQ(get(thing(entries[0])), nullptr);
    EXPECT_NE(get(thing(entries.back())), nullptr);
}

TEST_F(ResidencyTest, WhatIsExpectedDoesNotTakeThePlaceOfWhatIsAskedFor) {
    start(10000);
    auto step = thing(a_);
    step.steps = 16;
    step.step = 3;
    const auto third = bring(step);
    step.step = 4;
    ASSERT_NE(bring(step), nullptr);
    awaitRest();  // 5 to 8
    for (std::size_t i = residency_->loaded(); i < Residency::most; ++i)
        ASSERT_NE(bring(thing(entryOf(std::to_string(i)))), nullptr);
    budget_->beginGeneration();
    step.step = 3;  // the oldest of all; 2, 1, 0 and 15 follow
    EXPECT_EQ(get(step), third);
    awaitRest();
    EXPECT_EQ(get(step), third);
}

}  // namespace
}  // namespace mote::server
