// SPDX-License-Identifier: GPL-3.0-or-later
//
// What outlives a session's connection: by which secret, for how long, and how much of it.
#include "server/session/parked_sessions.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;

const ParkedSessions::Time start{std::chrono::hours(1)};

proto::SetView viewOf(std::uint64_t id, std::size_t size = 0) {
    proto::SetView view;
    view.set_view_id(id);
    view.mutable_view()->add_layers()->set_dataset(std::string(size, 'x'));
    return view;
}

TEST(ParkedSessions, AreTakenUpWithWhatTheyHad) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, start);
    EXPECT_FALSE(first.resumed);
    EXPECT_EQ(first.secret.size(), 64u);
    parked.setView(1, viewOf(7));
    parked.watchJobs(1);
    parked.left(1, start);
    const auto again = parked.admit(first.secret, 2, start + 1h);
    EXPECT_TRUE(again.resumed);
    EXPECT_EQ(again.before, 1u);
    ASSERT_TRUE(again.state.view);
    EXPECT_EQ(again.state.view->view_id(), 7u);
    EXPECT_TRUE(again.state.watchesJobs);
    EXPECT_EQ(parked.size(), 1u);
}

/// Uploads of a client that sent so many bytes.
std::shared_ptr<Uploads> uploadsOf(const std::filesystem::path& folder, std::size_t size) {
    auto uploads = std::make_shared<Uploads>(folder);
    proto::Upload part;
    part.set_name("a");
    part.set_size(size);
    part.set_data(std::string(size, 'x'));
    EXPECT_TRUE(uploads->add(part).ok());
    return uploads;
}

TEST(ParkedSessions, UploadsStayForAWhile) {
    const test::TempDir folder;
    ParkingLimits limits;
    limits.uploadsKept = 60s;
    ParkedSessions parked(limits);
    const auto first = parked.admit("", 1, start);
    parked.setUploads(1, uploadsOf(folder.path(), 10));
    parked.sweepUploads(start + 1h);
    EXPECT_FALSE(std::filesystem::is_empty(folder.path())) << "it is connected";
    parked.left(1, start);
    parked.sweepUploads(start + 59s);
    const auto second = parked.admit(first.secret, 2, start + 59s);
    ASSERT_TRUE(second.state.uploads);
    EXPECT_EQ(second.state.uploads->bytes(), 10U);
    parked.left(2, start + 1min);
    parked.sweepUploads(start + 2min);
    EXPECT_FALSE(std::filesystem::is_empty(folder.path())) << "who goes on with it has it still";
    EXPECT_FALSE(parked.admit(second.secret, 3, start + 2min).state.uploads);
}

TEST(ParkedSessions, UploadsOfWhoLeftFirstGoWhereTheyAreTooMany) {
    const test::TempDir folder;
    ParkingLimits limits;
    limits.uploadBytes = 250;
    ParkedSessions parked(limits);
    std::vector<std::string> secrets;
    for (SessionId session = 1; session <= 4; ++session) {
        secrets.push_back(parked.admit("", session, start).secret);
        parked.setUploads(session, uploadsOf(folder.path(), 100));
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 4);
    for (const SessionId session : {2, 1, 3})
        parked.left(session, start + std::chrono::seconds(session != 2));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3);
    EXPECT_FALSE(parked.admit(secrets[1], 5, start).state.uploads);
    EXPECT_TRUE(parked.admit(secrets[0], 6, start).state.uploads);
}

TEST(ParkedSessions, ASecretIsGoodOnce) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, start);
    const auto second = parked.admit(first.secret, 2, start);
    EXPECT_NE(first.secret, second.secret);
    parked.confirm(2);
    EXPECT_FALSE(parked.sessionOf(first.secret));
    EXPECT_EQ(parked.sessionOf(second.secret), 2u);
    EXPECT_FALSE(parked.admit(first.secret, 3, start).resumed);
}

/// The line may break before the welcome with the new one arrives.
TEST(ParkedSessions, ASecretStaysGoodUntilTheNextOneHasArrived) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, start);
    const auto lost = parked.admit(first.secret, 2, start);
    const auto second = parked.admit(first.secret, 3, start);
    EXPECT_TRUE(second.resumed);
    EXPECT_EQ(second.before, 2u);
    EXPECT_FALSE(parked.sessionOf(lost.secret)) << "nobody has it";
    parked.confirm(3);
    EXPECT_FALSE(parked.sessionOf(first.secret));
    EXPECT_TRUE(parked.sessionOf(second.secret));
}

TEST(ParkedSessions, OtherSecretsTakeUpNothing) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, start);
    auto almost = first.secret;
    almost.back() = almost.back() == '0' ? '1' : '0';
    for (const auto& secret : {std::string(), almost, first.secret + "0", first.secret.substr(1)}) {
        EXPECT_FALSE(parked.sessionOf(secret));
        EXPECT_FALSE(parked.admit(secret, 9, start).resumed);
    }
}

TEST(ParkedSessions, AreKeptForATimeAfterTheirConnectionsEnd) {
    ParkedSessions parked({.kept = 60s});
    const auto gone = parked.admit("", 1, start), here = parked.admit("", 2, start);
    parked.left(1, start);
    EXPECT_TRUE(parked.admit(here.secret, 3, start + 60s).resumed);
    EXPECT_TRUE(parked.sessionOf(gone.secret));
    parked.admit("", 4, start + 61s);
    EXPECT_FALSE(parked.sessionOf(gone.secret));
    EXPECT_EQ(parked.size(), 2u);
}

TEST(ParkedSessions, TheOldestGoWhereThereAreTooMany) {
    ParkedSessions parked({.number = 3});
    const auto connected = parked.admit("", 1, start);
    const auto late = parked.admit("", 2, start), early = parked.admit("", 3, start);
    parked.left(3, start + 1s);
    parked.left(2, start + 2s);
    parked.admit("", 4, start + 3s);
    EXPECT_TRUE(parked.sessionOf(connected.secret));
    EXPECT_TRUE(parked.sessionOf(late.secret));
    EXPECT_FALSE(parked.sessionOf(early.secret));
}

TEST(ParkedSessions, ViewsAreKeptAsFarAsThereIsRoom) {
    ParkedSessions parked({.bytes = 10'000});
    const auto gone = parked.admit("", 1, start), here = parked.admit("", 2, start);
    parked.setView(1, viewOf(1, 6000));
    parked.left(1, start);
    parked.setView(2, viewOf(2, 6000));
    EXPECT_FALSE(parked.sessionOf(gone.secret)) << "it made room";
    parked.setView(2, viewOf(3, 20'000));
    const auto again = parked.admit(here.secret, 3, start);
    EXPECT_TRUE(again.resumed);
    EXPECT_FALSE(again.state.view) << "too large, and the one before is not the latest";
}

TEST(ParkedSessions, ComeBackFromAFile) {
    int changes = 0;
    ParkedSessions before({}, [&] { ++changes; });
    const auto one = before.admit("", 1, start), two = before.admit("", 2, start);
    before.setView(1, viewOf(5));
    before.watchJobs(2);
    EXPECT_EQ(changes, 4);
    ParkedSessions after;
    const auto bytes = before.toBytes();
    ASSERT_TRUE(after.add(bytes, start).ok());
    const auto first = after.admit(one.secret, 1, start), second = after.admit(two.secret, 2, start);
    ASSERT_TRUE(first.resumed && second.resumed);
    EXPECT_EQ(first.before, 0u);
    EXPECT_EQ(first.state.view->view_id(), 5u);
    EXPECT_FALSE(first.state.watchesJobs);
    EXPECT_FALSE(second.state.view);
    EXPECT_TRUE(second.state.watchesJobs);
}

TEST(ParkedSessions, ADamagedFileIsAnErrorAndNoMore) {
    ParkedSessions before;
    before.admit("", 1, start);
    before.setView(1, viewOf(5));
    const auto good = before.toBytes();
    for (std::size_t size = 0; size < good.size(); ++size) {
        ParkedSessions after;
        const auto status = after.add(std::span(good).first(size), start);
        EXPECT_TRUE(status.ok() || status.error().code == ErrorCode::corrupt);
        EXPECT_LE(after.size(), 1u);
    }
    for (std::size_t at = 0; at < good.size(); ++at) {
        auto bad = good;
        bad[at] ^= 0xff;
        ParkedSessions after;
        const auto status = after.add(bad, start);
        EXPECT_TRUE(status.ok() || !status.error().message.empty());
        EXPECT_LE(after.size(), 1u);
    }
}

}  // namespace
}  // namespace mote::server
