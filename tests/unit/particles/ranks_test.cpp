// SPDX-License-Identifier: GPL-3.0-or-later
//
// Several ranks in one process: rounds of messages, and whole jobs.
#include <gtest/gtest.h>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_plan.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/particles/thread_ranks.h"

namespace mote::prep {
namespace {

Error roundFailure() {
    return {ErrorCode::internal, "there", "it failed"};
}

/// What went wrong where: in making or using the messages of a round.
struct Fault {
    int rank = -1;
    std::size_t round = 0;
    bool inUse = false;
};

/// Each rank tells each other a number for each round, which it must get. Returns how all of them ended.
std::vector<Status> tellNumbers(std::size_t ranks, std::size_t rounds, const Fault& fault) {
    std::vector<Status> ended(ranks, success());
    test::ThreadRanks all(ranks);
    all.run([&](Communicator& own) {
        const auto fails = [&](std::size_t round, bool inUse) {
            return own.rank() == fault.rank && round == fault.round && inUse == fault.inUse;
        };
        const auto number = [](int from, std::size_t to, std::size_t round) {
            return 100 * static_cast<std::size_t>(from) + 10 * to + round;
        };
        std::size_t used = 0;
        const auto make = [&](std::size_t round) -> Result<std::vector<Bytes>> {
            if (fails(round, false)) return roundFailure();
            std::vector<Bytes> outgoing(ranks);
            // Nothing for rank 0 in some rounds: an empty message is no error.
            for (std::size_t to = round % 2; to < ranks; ++to) {
                const auto one = number(own.rank(), to, round);
                addList(outgoing[to], std::span(&one, 1));
            }
            return outgoing;
        };
        const auto use = [&](std::size_t round, const std::vector<Bytes>& incoming) -> Status {
            if (fails(round, true)) return roundFailure();
            EXPECT_EQ(round, used++);
            for (std::size_t from = 0; from < ranks; ++from) {
                std::span<const std::byte> rest(incoming[from]);
                if (own.rank() == 0 && round % 2 == 1) continue;
                const auto list = takeList<std::size_t>(rest);
                EXPECT_EQ(list.front(),
                          number(static_cast<int>(from), static_cast<std::size_t>(own.rank()), round));
            }
            return success();
        };
        ended[static_cast<std::size_t>(own.rank())] = exchangeInRounds(own, rounds, make, use);
        if (fault.rank < 0) {
            EXPECT_EQ(used, rounds);
        }
    });
    return ended;
}

TEST(Rounds, BringEachMessageToItsRound) {
    for (const std::size_t ranks : {1U, 2U, 3U}) {
        for (const std::size_t rounds : {0U, 1U, 2U, 5U}) {
            for (const auto& ended : tellNumbers(ranks, rounds, {})) EXPECT_TRUE(ended.ok());
        }
    }
}

TEST(Rounds, AnErrorAnywhereIsThatOfAllRanks) {
    for (const std::size_t ranks : {1U, 2U, 3U}) {
        for (std::size_t round = 0; round < 4; ++round) {
            for (const bool inUse : {false, true}) {
                for (const auto& ended : tellNumbers(ranks, 4, {static_cast<int>(ranks) - 1, round, inUse})) {
                    ASSERT_FALSE(ended.ok());
                    EXPECT_EQ(ended.error().message, "it failed");
                }
            }
        }
    }
}

TEST(Lists, OfAMessageComeAsTheyWent) {
    Bytes message;
    addList<std::uint8_t>(message, std::array<std::uint8_t, 3>{1, 2, 3});
    addList<double>(message, {});
    const std::size_t at = addRoom<std::uint32_t>(message, 1);
    const std::uint32_t value = 77;
    std::memcpy(message.data() + at, &value, sizeof value);
    EXPECT_EQ(message.size(),
              listBytes<std::uint8_t>(3) + listBytes<double>(0) + listBytes<std::uint32_t>(1));
    std::span<const std::byte> rest(message);
    EXPECT_EQ(takeList<std::uint8_t>(rest)[2], 3);
    EXPECT_TRUE(takeList<double>(rest).empty());
    EXPECT_EQ(takeList<std::uint32_t>(rest)[0], 77U);
    EXPECT_TRUE(rest.empty());
}

using test::beamStep;
using test::contentOf;
using test::entriesOf;
using test::FakeSource;
using test::requestFor;

/// A job of so many ranks; rank `who` is cancelled once it was asked so often. Returns how all of them ended.
std::vector<Status> runTogether(std::size_t ranks, const std::vector<test::FakeStep>& steps,
                                const proto::JobRequest& request, const std::filesystem::path& output,
                                std::uint64_t memory, int who = -1, long after = 0) {
    std::vector<Status> ended(ranks, success());
    test::ThreadRanks all(ranks);
    all.run([&](Communicator& own) {
        FakeSource source(steps);
        std::optional<test::QuietProgress> progress;
        if (own.rank() == who) {
            progress.emplace(after);
        } else {
            progress.emplace();
        }
        JobResources resources{1, memory};
        resources.ranks = &own;
        const auto made = runParticlesJob(request, source, {output.parent_path() / "fake.h5"}, output,
                                          resources, *progress);
        if (!made.ok()) ended[static_cast<std::size_t>(own.rank())] = made.error();
    });
    return ended;
}

std::vector<test::FakeStep> weightedSteps() {
    std::vector<test::FakeStep> steps{beamStep(70000, 1), beamStep(1, 2), beamStep(0, 4), beamStep(3000, 3)};
    for (std::size_t i = 0; i < 70000; ++i) steps[0][Column::weight][i] = static_cast<double>(i % 9);
    return steps;
}

TEST(JobOfRanks, HasTheBytesOfOne) {
    const test::TempDir dir;
    const auto steps = weightedSteps();
    for (const std::uint32_t capacity : {1U, 32U, 100000U}) {
        auto request = requestFor();
        request.mutable_particles()->set_leaf_capacity(capacity);
        const auto alone = runTogether(1, steps, request, dir / "one.mote", 0);
        ASSERT_TRUE(alone[0].ok()) << alone[0].error().toString();
        const auto expected = contentOf(dir / "one.mote");
        // Also so little memory that particles lie in a file.
        const std::uint64_t little =
            planMemory(70000, stepOptionsOf(request.particles()), std::uint64_t{1} << 40, 1).needed + 1024;
        for (const std::size_t ranks : {2U, 3U, 5U}) {
            for (const std::uint64_t memory : {std::uint64_t{0}, little}) {
                SCOPED_TRACE(testing::Message() << capacity << ' ' << ranks << ' ' << memory);
                for (const auto& ended : runTogether(ranks, steps, request, dir / "a.mote", memory))
                    ASSERT_TRUE(ended.ok()) << ended.error().toString();
                EXPECT_TRUE(contentOf(dir / "a.mote") == expected);
                std::filesystem::remove_all(dir / "a.mote");
            }
        }
        std::filesystem::remove_all(dir / "one.mote");
    }
}

TEST(JobOfRanks, CancelledAnywhereEndsOnAllAndLeavesNothing) {
    const test::TempDir dir;
    const std::vector<test::FakeStep> steps{beamStep(3000, 1)};
    bool done = false;
    for (long after = 0; !done; ++after) {
        const auto ended =
            runTogether(2, steps, requestFor(), dir / "a.mote", 0, static_cast<int>(after % 2), after);
        done = ended[0].ok();
        EXPECT_EQ(ended[1].ok(), done);
        if (done) continue;
        EXPECT_EQ(ended[0].error().code, ErrorCode::cancelled);
        EXPECT_EQ(ended[1].error().code, ErrorCode::cancelled);
        EXPECT_EQ(entriesOf(dir.path()), 0U);
    }
}

/// Leaves that are sorted by all threads: no thread begins another range meanwhile.
TEST(LargeLeaves, AreThoseOfOneThreadEachTime) {
    const test::TempDir dir;
    FakeSource source({beamStep(500000, 6)});
    auto request = requestFor();
    request.mutable_particles()->set_leaf_capacity(100000);
    request.mutable_particles()->add_columns("none");
    ASSERT_TRUE(test::make(request, source, dir / "one.mote", {1, 0}).ok());
    const auto expected = contentOf(dir / "one.mote");
    for (int i = 0; i < 10; ++i) {
        ASSERT_TRUE(test::make(request, source, dir / "a.mote", {3, 0}).ok());
        EXPECT_TRUE(contentOf(dir / "a.mote") == expected);
        std::filesystem::remove_all(dir / "a.mote");
    }
}

}  // namespace
}  // namespace mote::prep
