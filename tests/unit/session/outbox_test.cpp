// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/outbox.h"

#include <gtest/gtest.h>

#include "protocol/base/utf8.h"
#include "server/session/token.h"

namespace mote::server {
namespace {

using Kind = Outbox::Item::Kind;

proto::ServerMessage pong(std::int64_t number) {
    proto::ServerMessage message;
    message.mutable_pong()->set_sent_ns(number);
    return message;
}

std::shared_ptr<const proto::JobStatus> job(const std::string& id, double progress = 0.0) {
    auto status = std::make_shared<proto::JobStatus>();
    status->set_id(id);
    status->set_progress(progress);
    return status;
}

std::size_t whole(const RenderedFrame&, std::size_t, std::size_t left) {
    return left;
}

void nobody(bool, bool) {
    ADD_FAILURE() << "a frame was dropped";
}

RenderedFrame frameOf(std::uint64_t view, proto::Frame::Encoding encoding = proto::Frame::JPEG) {
    RenderedFrame frame;
    frame.message.set_view_id(view);
    frame.message.set_encoding(encoding);
    frame.payload.resize(100);
    return frame;
}

/// The views of the frames that are sent.
std::vector<std::uint64_t> sentBy(Outbox& outbox) {
    std::vector<std::uint64_t> views;
    while (const auto item = outbox.next(whole)) views.push_back(item->frame->message.view_id());
    return views;
}

struct Drops {
    int whole = 0, partly = 0, ofStream = 0;
    Outbox::Dropped counter() {
        return [this](bool partlySent, bool stream) {
            ++(partlySent ? partly : whole);
            ofStream += stream;
        };
    }
};

using Views = std::vector<std::uint64_t>;
const Clock::time_point start{std::chrono::seconds(1000)};

TEST(Outbox, ANewerFrameTakesThePlaceOfOneThatWaits) {
    Outbox outbox;
    Drops drops;
    outbox.frame(frameOf(1), start, drops.counter());
    // A part of the first is sent; of a hundred more the newest stays.
    EXPECT_TRUE(outbox.next([](const RenderedFrame&, std::size_t, std::size_t) { return 40; }));
    for (std::uint64_t view = 2; view <= 101; ++view) {
        outbox.frame(frameOf(view), start, drops.counter());
        EXPECT_EQ(outbox.frames(), 2u);
    }
    EXPECT_EQ(drops.whole, 99);
    EXPECT_EQ(drops.partly, 0);
    EXPECT_EQ(sentBy(outbox), (Views{1, 101}));
}

TEST(Outbox, FramesThatSomebodyWaitsForStay) {
    Outbox outbox;
    for (std::uint64_t view = 1; view <= 2; ++view) {
        auto frame = frameOf(view);
        frame.wanted = true;
        outbox.frame(std::move(frame), start, nobody);
    }
    auto exact = frameOf(3);
    exact.quick = false;
    exact.canWait = true;
    outbox.frame(std::move(exact), start, nobody);
    outbox.frame(frameOf(4), start, nobody);
    outbox.dropStale(start + std::chrono::hours(1), 4, nobody);
    EXPECT_EQ(sentBy(outbox), (Views{1, 2, 3, 4}));
}

TEST(Outbox, FramesOfAStreamAreReplacedByWhatNeedsNone) {
    Outbox outbox;
    Drops drops;
    outbox.frame(frameOf(1, proto::Frame::H264), start, nobody);
    outbox.frame(frameOf(2, proto::Frame::H264), start, nobody);
    outbox.frame(frameOf(3, proto::Frame::ZSTD), start, drops.counter());
    EXPECT_EQ(drops.ofStream, 2);
    EXPECT_EQ(sentBy(outbox), (Views{3}));
}

TEST(Outbox, AfterADroppedFrameOfAStreamItBeginsAnewWithAKey) {
    Outbox outbox;
    Drops drops;
    outbox.frame(frameOf(1, proto::Frame::H264), start, nobody);
    outbox.dropStale(start + std::chrono::seconds(1), 9, drops.counter());
    // One that was encoded already tells nothing without it.
    outbox.frame(frameOf(2, proto::Frame::H264), start, drops.counter());
    EXPECT_EQ(drops.whole, 2);
    auto key = frameOf(3, proto::Frame::H264);
    key.message.set_key(true);
    outbox.frame(std::move(key), start, nobody);
    outbox.frame(frameOf(4, proto::Frame::H264), start, nobody);
    EXPECT_EQ(sentBy(outbox), (Views{3, 4}));
}

TEST(Outbox, WhatGrewOldBehindAClientThatDidNotReadIsNotSent) {
    Outbox outbox;
    Drops drops;
    outbox.frame(frameOf(1, proto::Frame::H264), start, nobody);
    outbox.frame(frameOf(2, proto::Frame::H264), start + std::chrono::seconds(9), nobody);
    outbox.dropStale(start, 2, nobody);
    // The first is old, and without it the second tells nothing.
    outbox.dropStale(start + std::chrono::seconds(1), 2, drops.counter());
    EXPECT_EQ(drops.whole, 2);
    EXPECT_EQ(drops.ofStream, 2);
    outbox.frame(frameOf(7), start, nobody);
    outbox.dropStale(start + std::chrono::hours(1), 7, nobody);
    EXPECT_EQ(sentBy(outbox), (Views{7})) << "it is of the latest view, however old";
}

TEST(Outbox, RepliesKeepTheirOrderAndTheirNumber) {
    Outbox outbox;
    EXPECT_FALSE(outbox.next(whole));
    for (std::size_t i = 0; i < Outbox::maxReplies; ++i) {
        EXPECT_TRUE(outbox.room());
        outbox.reply(pong(static_cast<std::int64_t>(i)));
    }
    EXPECT_FALSE(outbox.room());
    EXPECT_EQ(outbox.next(whole)->message.pong().sent_ns(), 0);
    EXPECT_TRUE(outbox.room());
    EXPECT_EQ(outbox.next(whole)->message.pong().sent_ns(), 1);
}

TEST(Outbox, AReplyWithManyBytesLeavesNoRoomUntilItIsSent) {
    Outbox outbox;
    outbox.reply({pong(0), std::vector<std::uint8_t>(Outbox::maxReplyBytes / 2, 7)});
    EXPECT_TRUE(outbox.room());
    outbox.reply({pong(1), std::vector<std::uint8_t>(Outbox::maxReplyBytes / 2, 8)});
    EXPECT_FALSE(outbox.room());
    const auto first = outbox.next(whole);
    EXPECT_EQ(first->kind, Kind::message);
    EXPECT_EQ(first->payload, std::vector<std::uint8_t>(Outbox::maxReplyBytes / 2, 7));
    EXPECT_TRUE(outbox.room());
    const auto second = outbox.next(whole);
    EXPECT_EQ(second->message.pong().sent_ns(), 1);
    EXPECT_EQ(second->payload, std::vector<std::uint8_t>(Outbox::maxReplyBytes / 2, 8));
}

TEST(Outbox, AReplyOfManyWordsLeavesNoRoomEither) {
    Outbox outbox;
    proto::ServerMessage jobs;
    for (int i = 0; i < 200; ++i) {
        auto& one = *jobs.mutable_jobs()->add_jobs();
        for (int line = 0; line < 5; ++line) one.add_log(std::string(2000, 'x'));
    }
    int lists = 0;
    for (; outbox.room(); ++lists) outbox.reply(jobs);
    EXPECT_EQ(lists, 1);
    while (outbox.next(whole)) {
    }
    EXPECT_TRUE(outbox.room());
}

TEST(Outbox, StateIsSentOnceHoweverOftenItChanged) {
    Outbox outbox;
    for (int i = 0; i < 100; ++i) {
        outbox.catalogueChanged();
        outbox.jobChanged(job(i % 2 == 0 ? "a" : "b", i));
        outbox.viewFailed(pong(i));
    }
    EXPECT_EQ(outbox.next(whole)->message.pong().sent_ns(), 99);
    EXPECT_EQ(outbox.next(whole)->job->progress(), 98);
    EXPECT_EQ(outbox.next(whole)->job->progress(), 99);
    EXPECT_EQ(outbox.next(whole)->kind, Kind::catalogue);
    EXPECT_FALSE(outbox.next(whole));
}

TEST(Outbox, TooManyChangedJobsBecomeTheWholeList) {
    Outbox outbox;
    for (int i = 0; i < 1000; ++i) outbox.jobChanged(job(std::to_string(i)));
    EXPECT_EQ(outbox.next(whole)->kind, Kind::allJobs);
    EXPECT_FALSE(outbox.next(whole));
    outbox.jobChanged(job("x"));
    EXPECT_EQ(outbox.next(whole)->kind, Kind::job);
}

/// A reply goes before changes, which would tell what was before it as the latest.
TEST(Outbox, WhatAReplyKnowsIsNotToldAfterIt) {
    Outbox outbox;
    for (const auto* const id : {"a", "b", "c"}) outbox.jobChanged(job(id));
    proto::ServerMessage one, list;
    one.mutable_job()->set_id("a");
    list.mutable_jobs()->add_jobs()->set_id("c");
    outbox.jobsTold(one);
    outbox.jobsTold(list);
    EXPECT_EQ(outbox.next(whole)->job->id(), "b");
    EXPECT_FALSE(outbox.next(whole));
    outbox.jobChanged(job("a", 0.5));
    EXPECT_EQ(outbox.next(whole)->job->progress(), 0.5);
}

TEST(Outbox, FarewellGoesBeforeAllAndIsTheFirstReason) {
    Outbox outbox;
    outbox.reply(pong(1));
    outbox.frame({}, {}, nobody);
    outbox.farewell(failureMessage(0, {ErrorCode::corrupt, "a", "first"}, true));
    outbox.farewell(failureMessage(0, {ErrorCode::corrupt, "b", "second"}, true));
    EXPECT_EQ(outbox.next(whole)->message.failure().message(), "first");
}

TEST(Failure, TextOfForeignFilesIsUtf8) {
    const auto message = failureMessage(3, {ErrorCode::notFound, "r\xe9sum\xe9.h5", "gone"}, false);
    EXPECT_EQ(message.failure().where(), "r?sum?.h5");
    EXPECT_EQ(message.reply_to(), 3u);
}

TEST(Utf8, TellsCharactersFromBytes) {
    for (const char* good : {"", "beam", "r\xc3\xa9sum\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x98\x80"}) {
        EXPECT_TRUE(isUtf8(good)) << good;
        EXPECT_EQ(toUtf8(good), good);
    }
    // Latin-1, overlong, surrogate, beyond Unicode, cut off.
    for (const char* bad : {"\xe9", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                            "\xe2\x82", "\xff", "a\x80z"}) {
        EXPECT_FALSE(isUtf8(bad));
        EXPECT_TRUE(isUtf8(toUtf8(bad)));
        EXPECT_NE(toUtf8(bad).find('?'), std::string::npos);
    }
}

TEST(Utf8, TextOfAClientIsNoLineOfTheLog) {
    EXPECT_EQ(toLogText("me\n2026 info all is well\x1b[2J\x7f"), "me?2026 info all is well?[2J?");
    EXPECT_EQ(toLogText(std::string(10000, 'x')).size(), 500u);
    EXPECT_TRUE(isUtf8(toLogText(std::string(499, 'x') + "\xc3\xa9")));
}

TEST(Token, IsLongRandomAndComparedWhole) {
    const std::string one = makeToken(), two = makeToken();
    EXPECT_EQ(one.size(), 64u);
    EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_NE(one, two);
    EXPECT_TRUE(sameToken(one, one));
    EXPECT_FALSE(sameToken(one, two));
    EXPECT_FALSE(sameToken(one, one.substr(0, 63)));
    EXPECT_FALSE(sameToken(one, one + "0"));
    EXPECT_FALSE(sameToken("", ""));
}

}  // namespace
}  // namespace mote::server
