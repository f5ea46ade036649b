// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "server/jobs/job_table.h"
#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

/// Of these states, submitted in this order.
JobTable tableOf(const std::filesystem::path& file, const std::vector<State::State>& states) {
    auto store = JobStore::open(file);
    EXPECT_TRUE(store.ok());
    JobTable table(*std::move(store));
    for (std::size_t i = 0; i < states.size(); ++i) {
        JobRecord record;
        record.status.set_id(fmt::format("{:016x}", i));
        record.status.set_state(states[i]);
        EXPECT_TRUE(table.add(std::move(record)).ok());
    }
    return table;
}

std::vector<std::string> idsOf(const std::vector<proto::JobStatus>& list) {
    std::vector<std::string> ids;
    for (const auto& status : list) ids.push_back(status.id());
    return ids;
}

/// What runs, then what waits, then what has ended; the newest first of each.
std::vector<std::string> wantedIds(const std::vector<State::State>& states, std::size_t most) {
    const auto rank = [&](std::size_t i) {
        return states[i] == State::RUNNING ? 0 : states[i] == State::QUEUED ? 1 : 2;
    };
    std::vector<std::size_t> order(states.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = order.size() - 1 - i;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return rank(a) < rank(b); });
    order.resize(std::min(order.size(), most));
    std::vector<std::string> ids;
    for (const auto i : order) ids.push_back(fmt::format("{:016x}", i));
    return ids;
}

TEST(JobTableTest, theRunningJobIsListedHoweverManyWait) {
    const test::TempDir folder;
    std::vector<State::State> states(300, State::QUEUED);
    states[3] = State::RUNNING;
    const auto list = tableOf(folder / "jobs.sqlite", states).list(200);
    ASSERT_EQ(list.size(), 200U);
    EXPECT_EQ(list[0].state(), State::RUNNING);
    EXPECT_EQ(list[0].id(), fmt::format("{:016x}", 3));
}

TEST(JobTableTest, theListIsInOrderWhateverItsJobs) {
    std::mt19937_64 random(20261123);
    for (int turn = 0; turn < 20; ++turn) {
        const test::TempDir folder;
        std::vector<State::State> states(random() % 60);
        for (auto& state : states) state = static_cast<State::State>(State::QUEUED + random() % 5);
        const std::size_t most = random() % 70;
        const auto table = tableOf(folder / "jobs.sqlite", states);
        EXPECT_EQ(idsOf(table.list(most)), wantedIds(states, most)) << "turn " << turn;
    }
}

TEST(JobTableTest, ClientsTakeTurns) {
    const test::TempDir folder;
    auto store = JobStore::open(folder / "jobs.sqlite");
    ASSERT_TRUE(store.ok());
    JobTable table(*std::move(store));
    std::size_t n = 0;
    for (const char* client : {"a", "a", "a", "b", "b", ""}) {
        JobRecord record;
        record.status.set_id(fmt::format("{:016x}", n++));
        record.status.set_state(State::QUEUED);
        record.client = client;
        ASSERT_TRUE(table.add(std::move(record)).ok());
    }
    const auto order = [&] {
        std::string text;
        for (const auto* record : table.queued(false)) text += record->status.id().back();
        return text;
    };
    EXPECT_EQ(order(), "035142");
    // Whose turn it was, waits for the others'.
    auto* first = table.queued(false).front();
    first->status.set_state(State::SUCCEEDED);
    first->status.set_started_ms(1000);
    EXPECT_EQ(order(), "35142");
    // Who has one that runs comes after those who have none.
    auto* second = table.queued(false).front();
    second->status.set_state(State::RUNNING);
    second->status.set_started_ms(1001);
    EXPECT_EQ(order(), "5124");
    EXPECT_EQ(table.waiting("a"), 2U);
    EXPECT_EQ(table.waiting("b"), 1U);
}

class DamagedStoreTest : public ::testing::Test {
  protected:
    static constexpr std::size_t count = 40;

    DamagedStoreTest() { tableOf(file_, std::vector<State::State>(count, State::SUCCEEDED)); }

    static std::string idOf(std::size_t i) { return fmt::format("{:016x}", i); }

    /// The job's row makes no sense any more.
    static void damage(const std::filesystem::path& file, std::size_t i) {
        std::ifstream in(file, std::ios::binary);
        std::string bytes{std::istreambuf_iterator<char>(in), {}};
        std::size_t found = 0;
        for (auto at = bytes.find(idOf(i)); at != std::string::npos; at = bytes.find(idOf(i), at)) {
            bytes[at] = 'z';
            ++found;
        }
        EXPECT_GT(found, 0U);
        std::ofstream(file, std::ios::binary) << bytes;
    }

    /// Twice: what the first one has mended, the second one finds.
    void expectAllBut(const std::vector<std::size_t>& lost) {
        for (int turn = 0; turn < 2; ++turn) {
            auto store = JobStore::open(file_);
            ASSERT_TRUE(store.ok());
            const auto jobs = store->load();
            ASSERT_TRUE(jobs.ok()) << jobs.error().toString();
            std::vector<std::string> ids, wanted;
            for (const auto& job : *jobs) ids.push_back(job.status.id());
            for (std::size_t i = 0; i < count; ++i) {
                if (std::ranges::count(lost, i) == 0) wanted.push_back(idOf(i));
            }
            EXPECT_EQ(ids, wanted) << "turn " << turn;
        }
    }

    const test::TempDir folder_;
    const std::filesystem::path file_ = folder_ / "jobs.sqlite", copy_ = JobStore::copyOf(file_);
};

TEST_F(DamagedStoreTest, AnEmptiedDatabaseGetsWhatADamagedCopyStillKnows) {
    damage(copy_, 5);
    std::filesystem::resize_file(file_, 0);
    expectAllBut({5});
}

TEST_F(DamagedStoreTest, ADatabaseThatIsGoneGetsWhatADamagedCopyStillKnows) {
    damage(copy_, 5);
    std::filesystem::remove(file_);
    expectAllBut({5});
}

TEST_F(DamagedStoreTest, WhatEitherFileKnowsIsKnown) {
    damage(file_, 3);
    damage(copy_, 5);
    expectAllBut({});
}

TEST_F(DamagedStoreTest, WhatNeitherKnowsTakesNoOther) {
    damage(file_, 3);
    damage(file_, 4);
    damage(copy_, 3);
    expectAllBut({3});
}

/// Any one byte of the database is changed: every job is known, as it was or as its row now says.
TEST(JobStoreTest, NoChangedByteTakesAJob) {
    const test::TempDir dir;
    const auto file = dir / "jobs.sqlite";
    std::vector<std::string> ids;
    {
        auto store = JobStore::open(file);
        ASSERT_TRUE(store.ok());
        JobTable table(*std::move(store));
        ASSERT_TRUE(table.load().ok());
        for (std::size_t i = 0; i < 40; ++i) {
            JobRecord record;
            record.status.set_id(fmt::format("{:016x}", i));
            record.status.set_state(State::SUCCEEDED);
            ids.push_back(record.status.id());
            ASSERT_TRUE(table.add(std::move(record)).ok());
        }
    }
    const auto bytes = std::filesystem::file_size(file);
    std::mt19937 random(7);
    for (int round = 0; round < 400; ++round) {
        const test::TempDir place;
        for (const auto& entry : std::filesystem::directory_iterator(dir.path()))
            std::filesystem::copy(entry.path(), place / entry.path().filename().string());
        const auto damaged = place / "jobs.sqlite";
        std::fstream bad(damaged, std::ios::in | std::ios::out | std::ios::binary);
        const auto at = static_cast<std::streamoff>(random() % bytes);
        bad.seekg(at);
        const int before = bad.get();
        bad.seekp(at);
        bad.put(static_cast<char>(before ^ static_cast<int>(1U << (random() % 8))));
        bad.close();
        auto store = JobStore::open(damaged);
        if (!store.ok()) {  // it says that it is of a newer version
            EXPECT_EQ(store.error().code, ErrorCode::unsupported);
            continue;
        }
        const auto jobs = store->load();
        ASSERT_TRUE(jobs.ok()) << jobs.error().toString() << ", byte " << at;
        EXPECT_EQ(jobs->size(), ids.size()) << "byte " << at;
    }
}

}  // namespace
}  // namespace mote::server
