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

const ParkedSessions::Time parkedStart{std::chrono::hours(1)};

proto::SetView parkedView(std::uint64_t id, std::size_t size = 0) {
    proto::SetView view;
    view.set_view_id(id);
    view.mutable_view()->add_layers()->set_dataset(std::string(size, 'x'));
    return view;
}

TEST(ParkedSessions, AreTakenUpWithWhatTheyHad) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, parkedStart);
    EXPECT_FALSE(first.resumed);
    EXPECT_EQ(first.secret.size(), 64u);
    parked.setView(1, parkedView(7));
    parked.watchJobs(1);
    parked.left(1, parkedStart);
    const auto again = parked.admit(first.secret, 2, parkedStart + 1h);
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
    const auto first = parked.admit("", 1, parkedStart);
    parked.setUploads(1, uploadsOf(folder.path(), 10));
    parked.sweepUploads(parkedStart + 1h);
    EXPECT_FALSE(std::filesystem::is_empty(folder.path())) << "it is connected";
    parked.left(1, parkedStart);
    parked.sweepUploads(parkedStart + 59s);
    const auto second = parked.admit(first.secret, 2, parkedStart + 59s);
    ASSERT_TRUE(second.state.uploads);
    EXPECT_EQ(second.state.uploads->bytes(), 10U);
    parked.left(2, parkedStart + 1min);
    parked.sweepUploads(parkedStart + 2min);
    EXPECT_FALSE(std::filesystem::is_empty(folder.path())) << "who goes on with it has it still";
    EXPECT_FALSE(parked.admit(second.secret, 3, parkedStart + 2min).state.uploads);
}

TEST(ParkedSessions, UploadsOfWhoLeftFirstGoWhereTheyAreTooMany) {
    const test::TempDir folder;
    ParkingLimits limits;
    limits.uploadBytes = 250;
    ParkedSessions parked(limits);
    std::vector<std::string> secrets;
    for (SessionId session = 1; session <= 4; ++session) {
        secrets.push_back(parked.admit("", session, parkedStart).secret);
        parked.setUploads(session, uploadsOf(folder.path(), 100));
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 4);
    for (const SessionId session : {2, 1, 3})
        parked.left(session, parkedStart + std::chrono::seconds(session != 2));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3);
    EXPECT_FALSE(parked.admit(secrets[1], 5, parkedStart).state.uploads);
    EXPECT_TRUE(parked.admit(secrets[0], 6, parkedStart).state.uploads);
}

TEST(ParkedSessions, ASecretIsGoodOnce) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, parkedStart);
    const auto second = parked.admit(first.secret, 2, parkedStart);
    EXPECT_NE(first.secret, second.secret);
    parked.confirm(2);
    EXPECT_FALSE(parked.sessionOf(first.secret));
    EXPECT_EQ(parked.sessionOf(second.secret), 2u);
    EXPECT_FALSE(parked.admit(first.secret, 3, parkedStart).resumed);
}

/// The line may break before the welcome with the new one arrives.
TEST(ParkedSessions, ASecretStaysGoodUntilTheNextOneHasArrived) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, parkedStart);
    const auto lost = parked.admit(first.secret, 2, parkedStart);
    const auto second = parked.admit(first.secret, 3, parkedStart);
    EXPECT_TRUE(second.resumed);
    EXPECT_EQ(second.before, 2u);
    EXPECT_FALSE(parked.sessionOf(lost.secret)) << "nobody has it";
    parked.confirm(3);
    EXPECT_FALSE(parked.sessionOf(first.secret));
    EXPECT_TRUE(parked.sessionOf(second.secret));
}

TEST(ParkedSessions, OtherSecretsTakeUpNothing) {
    ParkedSessions parked;
    const auto first = parked.admit("", 1, parkedStart);
    auto almost = first.secret;
    almost.back() = almost.back() == '0' ? '1' : '0';
    for (const auto& secret : {std::string(), almost, first.secret + "0", first.secret.substr(1)}) {
        EXPECT_FALSE(parked.sessionOf(secret));
        EXPECT_FALSE(parked.admit(secret, 9, parkedStart).resumed);
    }
}

TEST(ParkedSessions, AreKeptForATimeAfterTheirConnectionsEnd) {
    ParkedSessions parked({.kept = 60s});
    const auto gone = parked.admit("", 1, parkedStart), here = parked.admit("", 2, parkedStart);
    parked.left(1, parkedStart);
    EXPECT_TRUE(parked.admit(here.secret, 3, parkedStart + 60s).resumed);
    EXPECT_TRUE(parked.sessionOf(gone.secret));
    parked.admit("", 4, parkedStart + 61s);
    EXPECT_FALSE(parked.sessionOf(gone.secret));
    EXPECT_EQ(parked.size(), 2u);
}

TEST(ParkedSessions, TheOldestGoWhereThereAreTooMany) {
    ParkedSessions parked({.number = 3});
    const auto connected = parked.admit("", 1, parkedStart);
    const auto late = parked.admit("", 2, parkedStart), early = parked.admit("", 3, parkedStart);
    parked.left(3, parkedStart + 1s);
    parked.left(2, parkedStart + 2s);
    parked.admit("", 4, parkedStart + 3s);
    EXPECT_TRUE(parked.sessionOf(connected.secret));
    EXPECT_TRUE(parked.sessionOf(late.secret));
    EXPECT_FALSE(parked.sessionOf(early.secret));
}

TEST(ParkedSessions, ViewsAreKeptAsFarAsThereIsRoom) {
    ParkedSessions parked({.bytes = 10'000});
    const auto gone = parked.admit("", 1, parkedStart), here = parked.admit("", 2, parkedStart);
    parked.setView(1, parkedView(1, 6000));
    parked.left(1, parkedStart);
    parked.setView(2, parkedView(2, 6000));
    EXPECT_FALSE(parked.sessionOf(gone.secret)) << "it made room";
    parked.setView(2, parkedView(3, 20'000));
    const auto again = parked.admit(here.secret, 3, parkedStart);
    EXPECT_TRUE(again.resumed);
    EXPECT_FALSE(again.state.view) << "too large, and the one before is not the latest";
}

TEST(ParkedSessions, ComeBackFromAFile) {
    int changes = 0;
    ParkedSessions before({}, [&] { ++changes; });
    const auto one = before.admit("", 1, parkedStart), two = before.admit("", 2, parkedStart);
    before.setView(1, parkedView(5));
    before.watchJobs(2);
    EXPECT_EQ(changes, 4);
    ParkedSessions after;
    const auto bytes = before.toBytes();
    ASSERT_TRUE(after.add(bytes, parkedStart).ok());
    const auto first = after.admit(one.secret, 1, parkedStart),
               second = after.admit(two.secret, 2, parkedStart);
    ASSERT_TRUE(first.resumed && second.resumed);
    EXPECT_EQ(first.before, 0u);
    EXPECT_EQ(first.state.view->view_id(), 5u);
    EXPECT_FALSE(first.state.watchesJobs);
    EXPECT_FALSE(second.state.view);
    EXPECT_TRUE(second.state.watchesJobs);
}

TEST(ParkedSessions, ADamagedFileIsAnErrorAndNoMore) {
    ParkedSessions before;
    before.admit("", 1, parkedStart);
    before.setView(1, parkedView(5));
    const auto good = before.toBytes();
    for (std::size_t size = 0; size < good.size(); ++size) {
        ParkedSessions after;
        const auto status = after.add(std::span(good).first(size), parkedStart);
        EXPECT_TRUE(status.ok() || status.error().code == ErrorCode::corrupt);
        EXPECT_LE(after.size(), 1u);
    }
    for (std::size_t at = 0; at < good.size(); ++at) {
        auto bad = good;
        bad[at] ^= 0xff;
        ParkedSessions after;
        const auto status = after.add(bad, parkedStart);
        EXPECT_TRUE(status.ok() || !status.error().message.empty());
        EXPECT_LE(after.size(), 1u);
    }
}

}  // namespace
}  // namespace mote::server
