// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <random>

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

}  // namespace
}  // namespace mote::server
