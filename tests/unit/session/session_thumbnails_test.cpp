// SPDX-License-Identifier: GPL-3.0-or-later
//
// Thumbnails: drawn once, kept in the state directory, behind all that others want, of bounded number.
#include <gmock/gmock.h>

#include <algorithm>

#include "protocol/scene/dataset.h"
#include "server/session/thumbnails.h"
#include "tests/unit/session/session_fixture.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using server::Thumbnail;
using server::ThumbnailFiles;

constexpr const char* usual = "data/a";

proto::ClientMessage thumbnailOf(const std::string& dataset, std::uint64_t request = 0) {
    proto::ClientMessage message;
    message.set_request(request);
    message.mutable_get_thumbnail()->set_dataset(dataset);
    return message;
}

class SessionThumbnails : public SessionFixture {
  protected:
    SessionThumbnails() { TinyDataset().write(folder_ / "data" / "a.mote"); }

    fs::path folder() const { return folder_ / "state" / "thumbnails"; }
    std::vector<fs::path> files() const {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(folder())) files.push_back(entry.path());
        return files;
    }
    /// Its JPEG.
    std::vector<std::uint8_t> thumbnail(TestClient& client, const std::string& dataset = usual) {
        const auto answer = client.ask(thumbnailOf(dataset));
        const auto& told = answer.message.thumbnail();
        EXPECT_EQ(told.dataset(), dataset) << answer.message.ShortDebugString();
        EXPECT_EQ(told.width(), Thumbnail::width);
        EXPECT_EQ(told.height(), Thumbnail::height);
        EXPECT_GT(answer.payload.size(), 100U);
        EXPECT_TRUE(answer.payload.size() > 2 && answer.payload[0] == 0xff && answer.payload[1] == 0xd8);
        return answer.payload;
    }
    std::size_t renders() const { return control_->renders().size(); }
};

TEST_F(SessionThumbnails, AreDrawnOnceAndKeptForTheNextServer) {
    start();
    const auto first = thumbnail(*client());
    EXPECT_EQ(renders(), 1U);
    EXPECT_EQ(control_->renders()[0].width, Thumbnail::width);
    EXPECT_EQ(thumbnail(*client()), first);
    stop();
    start();
    EXPECT_EQ(thumbnail(*client()), first);
    EXPECT_EQ(renders(), 1U);
    // A damaged one is drawn anew, and is whole again.
    ASSERT_EQ(files().size(), 1U);
    std::fstream file(files()[0], std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(200).put('?').put('!');
    file.close();
    EXPECT_EQ(thumbnail(*client()), first);
    EXPECT_EQ(renders(), 2U);
    EXPECT_EQ(thumbnail(*client()), first);
    EXPECT_EQ(renders(), 2U);
}

TEST_F(SessionThumbnails, AChangedDatasetHasANewOne) {
    start();
    const auto one = client();
    thumbnail(*one);
    fs::remove_all(folder_ / "data" / "a.mote");
    TinyDataset other;
    other.threshold[0] = 0.25F;
    other.write(folder_ / "data" / "a.mote");
    proto::ClientMessage list;
    list.mutable_list_datasets();
    one->ask(list);
    thumbnail(*one);
    EXPECT_EQ(renders(), 2U);
    EXPECT_EQ(files().size(), 2U);
}

TEST_F(SessionThumbnails, GiveWayToAllThatOthersWant) {
    start();
    control_->closeGate();
    const auto lister = client();
    const auto script = client();
    lister->send(thumbnailOf(usual, 100));
    control_->awaitBegun(1);
    script->setView(1, 65, false, true);
    control_->awaitBegun(2);  // without a stop, the first would wait at the gate for ever
    control_->openGate();
    EXPECT_EQ(script->receiveFrame().message.frame().width(), 65U);
    EXPECT_TRUE(lister->receiveReply(100).message.has_thumbnail());
    ASSERT_EQ(renders(), 3U);
    EXPECT_TRUE(control_->renders()[0].stopped);
}

TEST_F(SessionThumbnails, OfWhatCannotBeShownAreFailuresOfTheirRequest) {
    server::CrashRecord crashes;
    settings_.render.crashes = &crashes;
    const auto view = firstView(usual, "particles", 1, Thumbnail::width, Thumbnail::height);
    crashes.count(view->SerializeAsString());
    start();
    const auto one = client();
    const auto failureOf = [&](const std::string& dataset) {
        return one->ask(thumbnailOf(dataset)).message.failure();
    };
    EXPECT_EQ(failureOf("data/none").code(), "not_found");
    EXPECT_EQ(failureOf("").code(), "not_found");
    EXPECT_THAT(failureOf(usual).message(), testing::HasSubstr("has ended the server before"));
    fs::copy(folder_ / "data" / "a.mote", folder_ / "data" / "b.mote");
    thumbnail(*one, "data/b");
    stop();
}

TEST_F(SessionThumbnails, OfOneClientFewWaitAndTheOldestGoes) {
    constexpr std::uint64_t asks = 10'000, first = 100, most = server::SessionThumbnails::mostAsked;
    start();
    control_->closeGate();
    const auto one = client();
    for (std::uint64_t i = 0; i < asks; ++i) {
        ASSERT_TRUE(one->send(thumbnailOf(usual, first + i)));
        if (i < most) continue;
        const auto answer = one->receiveReply(first + i - most).message;
        ASSERT_EQ(answer.failure().code(), "resource_exhausted");
    }
    control_->openGate();
    for (std::uint64_t i = asks - most; i < asks; ++i) {
        const auto answer = one->receive([](const auto& message) { return message.reply_to() >= first; });
        EXPECT_TRUE(answer.message.has_thumbnail());
    }
    EXPECT_EQ(renders(), 1U);
}

/// A key of one digit, and a thumbnail of so many bytes.
std::string keyOf(char digit) {
    return std::string(32, digit);
}
Thumbnail ofBytes(std::size_t bytes, std::uint8_t value) {
    return {std::vector<std::uint8_t>(bytes, value)};
}

TEST(ThumbnailFiles, TakeNoMoreRoomThanTheyMayAndTheOldestGo) {
    const TempDir dir;
    const auto folder = dir / "thumbnails";
    constexpr std::uint64_t room = 3500;
    {
        ThumbnailFiles files(folder, room);
        for (const char digit : {'1', '2', '3'}) files.keep(keyOf(digit), ofBytes(1000, 7));
        EXPECT_TRUE(files.find(keyOf('1')).has_value());
        files.keep(keyOf('4'), ofBytes(1000, 8));
        EXPECT_FALSE(files.find(keyOf('2')).has_value());  // it was used longest ago
        EXPECT_EQ(files.find(keyOf('4'))->jpeg, ofBytes(1000, 8).jpeg);
        files.keep(keyOf('5'), ofBytes(room, 9));  // more than there is
        EXPECT_FALSE(files.find(keyOf('5')).has_value());
        EXPECT_LE(files.bytes(), room);
    }
    const auto now = fs::file_time_type::clock::now();
    for (const auto& [digit, age] : {std::pair{'1', 3}, {'3', 1}, {'4', 2}})
        fs::last_write_time(folder / (keyOf(digit) + ".thumbnail"), now - std::chrono::hours(age));
    std::ofstream(folder / (keyOf('6') + ".thumbnail.AbCdEf")) << "not finished";
    std::ofstream(folder / "notes") << "of somebody";
    {
        ThumbnailFiles files(folder, room);
        files.keep(keyOf('7'), ofBytes(1000, 1));
        EXPECT_FALSE(files.find(keyOf('1')).has_value());
        EXPECT_TRUE(files.find(keyOf('3')).has_value());
    }
    const ThumbnailFiles small(folder, room / 3);  // less than before: the next server
    EXPECT_LE(small.bytes(), room / 3);
    EXPECT_FALSE(fs::exists(folder / (keyOf('6') + ".thumbnail.AbCdEf")));
    EXPECT_TRUE(fs::exists(folder / "notes"));
}

TEST(ThumbnailFiles, WhoseFolderIsNotOursKeepNothing) {
    const TempDir dir;
    std::ofstream(dir / "thumbnails") << "a file";
    ThumbnailFiles files(dir / "thumbnails");
    files.keep(keyOf('1'), ofBytes(10, 1));
    EXPECT_FALSE(files.find(keyOf('1')).has_value());
}

TEST(ThumbnailFiles, AreNotTakenFromOtherSizesOrCutShort) {
    const TempDir dir;
    ThumbnailFiles files(dir / "thumbnails");
    const auto file = dir / "thumbnails" / (keyOf('1') + ".thumbnail");
    const auto spoil = [&](const std::function<void(std::string&)>& how) {
        files.keep(keyOf('1'), ofBytes(500, 3));
        std::string text;
        std::getline(std::ifstream(file), text, char(255));
        how(text);
        std::ofstream(file, std::ios::trunc) << text;
        EXPECT_FALSE(files.find(keyOf('1')).has_value());
        EXPECT_FALSE(fs::exists(file));
    };
    spoil([](std::string& text) { text.pop_back(); });
    spoil([](std::string& text) { text += "more"; });
    spoil([](std::string& text) { text.clear(); });
    spoil([](std::string& text) { text.replace(text.find("192"), 3, "191"); });
    spoil([](std::string& text) { text.assign(std::size_t{2} << 20, 'x'); });
}

}  // namespace
}  // namespace mote::test
