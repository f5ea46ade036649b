// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"
#include "tests/unit/client/frames.h"

namespace mote::client {
namespace {

constexpr const char* key = "0123456789abcdef0123456789abcdef";

class FrameStoreTest : public testing::Test {
  protected:
    FramePixels pixels(std::uint32_t width) const {
        return {width, 4, proto::SRGB8, test::samplePixels(width, 4, proto::SRGB8)};
    }

    test::TempDir folder_;
    FrameStore store_{folder_ / "film.mp4"};
};

TEST_F(FrameStoreTest, GivesBackWhatWasPut) {
    ASSERT_TRUE(store_.open(false).ok());
    EXPECT_FALSE(store_.has(0, key));
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    const auto payload = test::zstdPayload(pixels(9).bytes, 9, proto::SRGB8);
    ASSERT_TRUE(store_.put(7, key, pixels(9), {payload.begin(), payload.end()}).ok());
    EXPECT_TRUE(store_.has(0, key));
    EXPECT_TRUE(store_.has(7, key));
    EXPECT_FALSE(store_.has(1, key));
    EXPECT_EQ(store_.read(0)->bytes, pixels(8).bytes);
    EXPECT_EQ(store_.read(7)->bytes, pixels(9).bytes);
    EXPECT_EQ(store_.read(1).error().code, ErrorCode::notFound);
}

TEST_F(FrameStoreTest, KnowsWhatAFrameShows) {
    ASSERT_TRUE(store_.open(false).ok());
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    EXPECT_FALSE(store_.has(0, "another"));
    EXPECT_FALSE(store_.has(0, ""));
}

TEST_F(FrameStoreTest, KeepsFramesOnlyWhereAskedTo) {
    ASSERT_TRUE(store_.open(false).ok());
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    ASSERT_TRUE(store_.open(true).ok());
    EXPECT_TRUE(store_.has(0, key));
    ASSERT_TRUE(store_.open(false).ok());
    EXPECT_FALSE(store_.has(0, key));
    store_.discard();
    EXPECT_FALSE(std::filesystem::exists(store_.folder()));
}

/// Every byte of a frame's file changed, and every length of it: never a wrong picture.
TEST_F(FrameStoreTest, DamageIsNoPicture) {
    ASSERT_TRUE(store_.open(false).ok());
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    const auto path = store_.folder() / "frame-000000";
    std::ifstream file(path, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(file), {}};
    const auto write = [&](const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; };
    for (std::size_t size = 0; size < whole.size(); ++size) {
        write(whole.substr(0, size));
        EXPECT_FALSE(store_.has(0, key)) << size;
        EXPECT_FALSE(store_.read(0).ok()) << size;
    }
    for (std::size_t place = 0; place < whole.size(); ++place) {
        auto changed = whole;
        changed[place] = static_cast<char>(changed[place] ^ 0x15);
        write(changed);
        const auto read = store_.read(0);
        // A byte of the heading that says nothing about the pixels may change, and zstd's checksum finds the
        // others.
        EXPECT_TRUE(!read.ok() || read->bytes == pixels(8).bytes) << place;
    }
}

TEST_F(FrameStoreTest, AFileInItsPlaceIsSaid) {
    std::ofstream(folder_ / ".film.mp4.frames") << "a file";
    const auto opened = store_.open(true);
    ASSERT_FALSE(opened.ok());
    EXPECT_NE(opened.error().toString().find(".film.mp4.frames"), std::string::npos);
}

}  // namespace
}  // namespace mote::client
