// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <algorithm>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "client/shared/film_download.h"
#include "client/shared/part_file.h"
#include "protocol/base/json.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/film/film_job.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

proto::View viewOf(unsigned width) {
    proto::View view;
    view.set_width(width);
    view.add_layers()->set_dataset(std::string(20000, 'd'));
    return view;
}

std::string textOf(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

class SaveJson : public testing::Test {
  protected:
    /// Nothing hidden is left beside them.
    std::size_t files() const {
        const std::filesystem::directory_iterator all(folder_.path());
        return static_cast<std::size_t>(std::distance(begin(all), end(all)));
    }

    test::TempDir folder_;
    const std::filesystem::path path_ = folder_ / "view.json";
};

TEST_F(SaveJson, WritesWhatIsRead) {
    ASSERT_TRUE(saveJson(path_, viewOf(7), SameName::stays).ok());
    EXPECT_EQ(textOf(path_), toJson(viewOf(7)));
    EXPECT_EQ(files(), 1U);
}

TEST_F(SaveJson, LeavesWhatIsThereUnlessItIsToBeReplaced) {
    std::ofstream(path_) << "mine";
    const auto refused = saveJson(path_, viewOf(7), SameName::stays);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::alreadyExists);
    EXPECT_EQ(textOf(path_), "mine");
    EXPECT_EQ(files(), 1U);
    ASSERT_TRUE(saveJson(path_, viewOf(7), SameName::isReplaced).ok());
    EXPECT_EQ(textOf(path_), toJson(viewOf(7)));
}

TEST_F(SaveJson, LeavesALinkThatLeadsNowhere) {
    std::filesystem::create_symlink("nowhere", path_);
    EXPECT_EQ(saveJson(path_, viewOf(7), SameName::stays).error().code, ErrorCode::alreadyExists);
    EXPECT_TRUE(std::filesystem::is_symlink(path_));
}

TEST_F(SaveJson, AFullDiskLeavesWhatWasThere) {
    std::ofstream(path_) << "mine";
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{4096, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const auto saved = saveJson(path_, viewOf(7), SameName::isReplaced);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(saved.ok());
    EXPECT_FALSE(saved.error().message.empty());
    EXPECT_EQ(textOf(path_), "mine");
    EXPECT_EQ(files(), 1U);
}

TEST_F(SaveJson, SaysWhereItCannotWrite) {
    EXPECT_EQ(saveJson(folder_ / "none" / "view.json", viewOf(7), SameName::stays).error().code,
              ErrorCode::notFound);
    EXPECT_EQ(saveJson(folder_.path(), viewOf(7), SameName::isReplaced).error().code,
              ErrorCode::alreadyExists);
}

using Bytes = std::vector<std::uint8_t>;
using test::Random;

Bytes anyBytes(Random& random, std::size_t most) {
    Bytes bytes(1 + random.below(most));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 40);
    return bytes;
}

/// A finished job of a film of `frames` frames.
proto::JobStatus jobOf(const std::string& video, int frames) {
    proto::JobStatus job;
    job.set_id("job-7");
    auto& film = *job.mutable_request()->mutable_film();
    film.set_video(video);
    film.mutable_script()->set_fps(1.0);
    for (const int seconds : {0, frames - 1}) {
        auto& keyframe = *film.mutable_script()->add_keyframes();
        keyframe.set_seconds(seconds);
        keyframe.mutable_view()->set_width(64);
        keyframe.mutable_view()->set_height(64);
        keyframe.mutable_view()->add_layers()->set_dataset("data/beam");
        keyframe.mutable_view()->mutable_layers(0)->mutable_particles();
    }
    return job;
}

Bytes readBytes(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t filesIn(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

/// What a server answers: a piece of at most `most` bytes.
FilmBytes answer(const Bytes& file, const proto::FetchFilm& wanted, std::size_t most) {
    FilmBytes piece;
    piece.message.set_size(file.size());
    piece.message.set_begin(wanted.begin());
    const auto begin = file.begin() + static_cast<std::ptrdiff_t>(wanted.begin());
    const auto size = std::min<std::size_t>(most, file.size() - wanted.begin());
    piece.bytes.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
    return piece;
}

TEST(FilmDownload, AVideoArrivesWholeAndOnlyThen) {
    for (std::uint64_t number = 0; number < 50; ++number) {
        const test::TempDir folder;
        Random random(51, number);
        const auto film = anyBytes(random, 5000);
        auto download = FilmDownload::begin(jobOf("mp4", 3), folder / "film.mp4").value();
        double progress = 0.0;
        while (!download->done()) {
            ASSERT_FALSE(std::filesystem::exists(folder / "film.mp4"));
            ASSERT_GE(download->progress().value(), progress);
            progress = download->progress().value();
            ASSERT_EQ(download->wanted().id(), "job-7");
            ASSERT_FALSE(download->wanted().has_frame());
            ASSERT_TRUE(download->take(answer(film, download->wanted(), 1 + random.below(2000))).ok());
        }
        EXPECT_EQ(download->progress(), 1.0);
        EXPECT_EQ(readBytes(folder / "film.mp4"), film);
        EXPECT_EQ(filesIn(folder.path()), 1U);
    }
}

TEST(FilmDownload, PicturesArriveInAFolder) {
    const test::TempDir folder;
    Random random(52);
    const auto job = jobOf("", 5);
    auto download = FilmDownload::begin(job, folder / "new" / "pictures").value();
    EXPECT_FALSE(download->progress().has_value());
    std::map<std::uint32_t, Bytes> pictures;
    for (std::uint32_t i = 0; i < 5; ++i) pictures[i] = anyBytes(random, 900);
    while (!download->done()) {
        const auto wanted = download->wanted();
        ASSERT_TRUE(wanted.has_frame());
        if (wanted.frame() < pictures.size()) {
            ASSERT_TRUE(download->take(answer(pictures.at(wanted.frame()), wanted, 200)).ok());
        } else {
            ASSERT_TRUE(download->take(Error{ErrorCode::notFound, "frame", "there are 5 frames"}).ok());
        }
    }
    EXPECT_EQ(download->filesDone(), 5U);
    EXPECT_EQ(filesIn(folder / "new" / "pictures"), 5U);
    for (const auto& [frame, bytes] : pictures)
        EXPECT_EQ(readBytes(folder / "new" / "pictures" / filmPictureName(job.request().film(), frame)),
                  bytes);
}

TEST(FilmDownload, WhatIsGivenUpLeavesNothing) {
    const test::TempDir folder;
    std::ofstream(folder / "film.mp4") << "the one before";
    {
        auto download = FilmDownload::begin(jobOf("mp4", 3), folder / "film.mp4").value();
        ASSERT_TRUE(download->take(answer(Bytes(1000, 7), download->wanted(), 300)).ok());
        // Another process, or another window, must not write the same file.
        const auto second = FilmDownload::begin(jobOf("mp4", 3), folder / "film.mp4");
        ASSERT_FALSE(second.ok());
        EXPECT_EQ(second.error().code, ErrorCode::alreadyExists);
    }
    EXPECT_EQ(filesIn(folder.path()), 1U);
    EXPECT_EQ(readBytes(folder / "film.mp4").size(), 14U) << "the one before";
}

TEST(FilmDownload, PiecesOfAnotherFileAreRefused) {
    const test::TempDir folder;
    const Bytes film(1000, 7);
    const auto refused = [&](const std::function<void(FilmBytes&)>& damage) {
        auto download = FilmDownload::begin(jobOf("mp4", 3), folder / "film.mp4").value();
        EXPECT_TRUE(download->take(answer(film, download->wanted(), 300)).ok());
        auto piece = answer(film, download->wanted(), 300);
        damage(piece);
        const auto taken = download->take(piece);
        return !taken.ok() && taken.error().code == ErrorCode::corrupt;
    };
    EXPECT_FALSE(refused([](FilmBytes&) {}));
    EXPECT_TRUE(refused([](FilmBytes& piece) { piece.message.set_begin(0); }));
    EXPECT_TRUE(refused([](FilmBytes& piece) { piece.message.set_size(999); }));
    EXPECT_TRUE(refused([](FilmBytes& piece) { piece.bytes.clear(); }));
    EXPECT_TRUE(refused([](FilmBytes& piece) { piece.bytes.resize(701); }));
    auto download = FilmDownload::begin(jobOf("mp4", 3), folder / "film.mp4").value();
    auto huge = answer(film, download->wanted(), 300);
    huge.message.set_size(std::uint64_t{1} << 60);
    EXPECT_FALSE(download->take(huge).ok());
    download.reset();
    EXPECT_EQ(filesIn(folder.path()), 0U);
}

TEST(FilmDownload, SaysAtOnceWhereItCannotWrite) {
    const test::TempDir folder;
    const auto missing = FilmDownload::begin(jobOf("mp4", 3), folder / "none" / "film.mp4");
    ASSERT_FALSE(missing.ok());
    EXPECT_NE(missing.error().toString().find("none/film.mp4"), std::string::npos);
    EXPECT_FALSE(FilmDownload::begin(jobOf("mp4", 3), folder.path()).ok());
    proto::JobStatus plot;
    plot.mutable_request()->mutable_particles();
    EXPECT_FALSE(FilmDownload::begin(plot, folder / "film.mp4").ok());
    auto none = FilmDownload::begin(jobOf("", 3), folder / "pictures").value();
    EXPECT_FALSE(none->take(Error{ErrorCode::notFound, "frame", "there is none"}).ok()) << "not even one";
}

}  // namespace
}  // namespace mote::client
