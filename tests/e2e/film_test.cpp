// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films by mote-frames: the same bytes whoever draws them, goes on after a kill, and leaves nothing
// half-written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include "protocol/wire/connection_file.h"
#include "tests/e2e/station.h"

namespace mote::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A turn about the beam while its steps are played.
std::string turn(int width = 96, double seconds = 0.5, const std::string& dataset = "data/beam") {
    return "{'fps': 24, 'view': {'width': " + std::to_string(width) +
           ", 'height': " + std::to_string(width * 3 / 4) + ", 'layers': [{'dataset': '" + dataset +
           "', 'particles': {}}]}, 'betweenSteps': 'blend', 'moves': "
           "[{'turn': {'degrees': 360}, 'playSteps': {'from': 0, 'to': 1}, 'seconds': " +
           std::to_string(seconds) + "}]}";
}

std::set<int> indicesIn(const std::string& lines) {
    static const std::regex index(R"("index": (\d+))");
    std::set<int> indices;
    for (std::sregex_iterator match(lines.begin(), lines.end(), index), end; match != end; ++match)
        EXPECT_TRUE(indices.insert(std::stoi((*match)[1])).second);
    return indices;
}

class Films : public testing::Test {
  protected:
    ProcessOptions options() const { return {{{"TMPDIR", station_.temporary().string()}}, {}}; }
    std::vector<std::string> spawn(std::vector<std::string> more = {}) const {
        more.insert(more.end(), {"--spawn", "data=" + station_.root().string(), "--device", "cpu"});
        return more;
    }
    /// mote-frames with a video and no folder of pictures.
    Finished film(const std::string& script, const std::filesystem::path& video,
                  const std::vector<std::string>& more) const {
        return runProcess(program("mote-frames"), arguments(script, video, more), options());
    }
    std::vector<std::string> arguments(const std::string& script, const std::filesystem::path& video,
                                       const std::vector<std::string>& more) const {
        auto json = script;
        std::replace(json.begin(), json.end(), '\'', '"');
        std::vector<std::string> words{station_.writeScript(json).string(), "--video", video.string(),
                                       "--quiet"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    std::filesystem::path videos() const {
        std::filesystem::create_directories(folder_ / "videos");
        return folder_ / "videos";
    }

    Station station_;
    TempDir folder_;
};

TEST_F(Films, AreTheSameBytesWhoeverDrawsThem) {
    const auto one = film(turn(), videos() / "one.mp4", spawn({"--threads", "1", "--json"}));
    ASSERT_EQ(one.status, 0) << one.errors;
    EXPECT_THAT(indicesIn(one.output), SizeIs(12));
    const auto bytes = bytesOf(videos() / "one.mp4");
    EXPECT_GT(bytes.size(), 1000U);
    for (const std::vector<std::string>& how :
         std::vector<std::vector<std::string>>{{"--threads", "3"}, {"--jobs", "2"}}) {
        const auto done = film(turn(), videos() / "again.mp4", spawn({how[0], how[1], "--force"}));
        ASSERT_EQ(done.status, 0) << done.errors;
        EXPECT_EQ(bytesOf(videos() / "again.mp4"), bytes) << how[0];
    }
    station_.startServer();
    const auto done =
        film(turn(), videos() / "again.mp4", {"--connect", station_.connection().string(), "--force"});
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_EQ(bytesOf(videos() / "again.mp4"), bytes);
    EXPECT_THAT(namesIn(videos()), testing::ElementsAre("again.mp4", "one.mp4"));
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
}

TEST_F(Films, GoOnWhereTheyWereKilled) {
    const auto whole = film(turn(128, 2.0), videos() / "whole.mp4", spawn());
    ASSERT_EQ(whole.status, 0) << whole.errors;
    const auto video = videos() / "film.mp4";
    const auto store = videos() / ".film.mp4.frames";
    std::mt19937 random(1);
    std::set<std::string> complete;
    for (int kill = 0; kill < 10; ++kill) {
        Process frames(program("mote-frames"),
                       arguments(turn(128, 2.0), video, spawn({"--resume", "--json"})), options());
        frames.wait(std::chrono::milliseconds(200 + random() % 700));
        frames.signal(SIGKILL);
        frames.wait();
        for (const int index : indicesIn(frames.output())) {
            char name[20];
            std::snprintf(name, sizeof name, "frame-%06d", index);
            EXPECT_EQ(complete.count(name), 0U) << name << " was drawn twice";
        }
        for (const auto& name : namesIn(store)) complete.insert(name);
        if (std::filesystem::exists(video)) break;
        complete.erase(complete.lower_bound("."), complete.lower_bound("/"));  // half-written ones
    }
    const auto last = film(turn(128, 2.0), video, spawn({"--resume"}));
    ASSERT_EQ(last.status, 0) << last.errors;
    EXPECT_EQ(bytesOf(video), bytesOf(videos() / "whole.mp4"));
    EXPECT_THAT(namesIn(videos()), testing::ElementsAre("film.mp4", "whole.mp4"));
    // What is complete is not begun again, though its frames are still there.
    std::filesystem::create_directory(store);
    std::ofstream(store / "frame-000000") << "left";
    const auto again = film(turn(128, 2.0), video, spawn({"--resume", "--json"}));
    EXPECT_EQ(again.status, 0) << again.errors;
    EXPECT_EQ(again.output, "");
    EXPECT_THAT(namesIn(videos()), testing::ElementsAre("film.mp4", "whole.mp4"));
}

TEST_F(Films, KeepTheirFrames) {
    auto more = spawn({"--keep-frames", "--out", station_.out().string(), "--format", "png16"});
    const auto done = film(turn(64), videos() / "film.webm", more);
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_THAT(namesIn(station_.out()), SizeIs(12));
    EXPECT_THAT(namesIn(videos()), testing::ElementsAre("film.webm"));
}

TEST_F(Films, AHoldIsOnePictureManyTimes) {
    auto script = turn(64);
    const std::string hold = ", {'hold': {}, 'seconds': 1}]}";
    script.replace(script.size() - 2, 2, hold);
    auto done = station_.frames(script, spawn({"--json"}), options());
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_THAT(indicesIn(done.output), SizeIs(36));
    const auto names = namesIn(station_.out());
    ASSERT_THAT(names, SizeIs(36));
    std::set<std::string> moving, held;
    for (std::size_t i = 0; i < names.size(); ++i)
        (i < 12 ? moving : held).insert(bytesOf(station_.out() / names[i]));
    EXPECT_THAT(moving, SizeIs(12));
    EXPECT_THAT(held, SizeIs(1));
}

TEST_F(Films, SamplesAndBlurChangeThePicture) {
    std::set<std::string> kinds;
    for (const std::vector<std::string>& how : std::vector<std::vector<std::string>>{
             {"--samples", "1"}, {"--samples", "4"}, {"--shutter", "180"}}) {
        const auto done = film(turn(64), videos() / "film.gif", spawn({how[0], how[1], "--force"}));
        ASSERT_EQ(done.status, 0) << done.errors;
        kinds.insert(bytesOf(videos() / "film.gif"));
    }
    EXPECT_THAT(kinds, SizeIs(3));
}

struct Bad {
    const char* name;
    std::string script;
    std::vector<std::string> more;
    const char* said;
    int status = 1;
};

void PrintTo(const Bad& bad, std::ostream* out) {
    *out << bad.script;
}

class BadFilm : public Films, public testing::WithParamInterface<Bad> {};

TEST_P(BadFilm, IsOneSentence) {
    const auto done = film(GetParam().script, videos() / "film.mp4", spawn(GetParam().more));
    EXPECT_EQ(done.status, GetParam().status);
    EXPECT_THAT(done.errors, HasSubstr(GetParam().said));
    const auto lines = std::count(done.errors.begin(), done.errors.end(), '\n');
    EXPECT_TRUE(GetParam().status != 1 || lines == 1) << done.errors;
    EXPECT_THAT(namesIn(videos()), IsEmpty());
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
}

const std::string still =
    "{'width': 64, 'height': 48, 'layers': [{'dataset': 'data/beam', 'particles': {}}]}";

INSTANTIATE_TEST_SUITE_P(
    Table, BadFilm,
    testing::Values(
        Bad{"OddSize", turn(97), {}, "97"}, Bad{"NoSuchDataset", turn(96, 0.5, "data/none"), {}, "data/none"},
        Bad{"OneKeyframe", "{'keyframes': [{'seconds': 0, 'view': " + still + "}]}", {}, "keyframes"},
        Bad{"EqualTimes",
            "{'keyframes': [{'seconds': 1, 'view': " + still + "}, {'seconds': 1, 'view': " + still + "}]}",
            {},
            "keyframes[1].seconds"},
        Bad{"OutOfOrder",
            "{'keyframes': [{'seconds': 2, 'view': " + still + "}, {'seconds': 1, 'view': " + still + "}]}",
            {},
            "keyframes[1].seconds"},
        Bad{"NoFrames", "{'views': []}", {}, "views"}, Bad{"TooManyFrames", turn(96, 1e9), {}, "moves"},
        Bad{"TwoSizes", "{'views': [" + still + ", {'width': 32, 'height': 48}]}", {}, "views[1].width"},
        Bad{"NoVideo", turn(), {"--video", "film.avi"}, "--video", 2},
        Bad{"Quality", turn(), {"--crf", "60"}, "crf"},
        Bad{"BlurOfViews", "{'views': [" + still + "]}", {"--shutter", "90"}, "shutter"}),
    [](const auto& each) { return each.param.name; });

TEST_F(Films, AVideoOfAnUnknownKindIsAWrongUsage) {
    const auto done = film(turn(), videos() / "film.avi", spawn());
    EXPECT_EQ(done.status, 2);
    EXPECT_THAT(done.errors, HasSubstr("--video"));
    EXPECT_THAT(done.errors, HasSubstr("film.avi"));
}

TEST_F(Films, AVideoThatIsThereStays) {
    std::ofstream(videos() / "film.mp4") << "precious";
    const auto done = film(turn(), videos() / "film.mp4", spawn());
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("film.mp4"));
    EXPECT_EQ(bytesOf(videos() / "film.mp4"), "precious");
    EXPECT_THAT(namesIn(videos()), SizeIs(1));
}

TEST_F(Films, ADatasetThatVanishesIsNamedAndTheFramesStay) {
    Process frames(program("mote-frames"),
                   arguments(turn(128, 100.0), videos() / "film.mp4", spawn({"--json"})), options());
    ASSERT_TRUE(frames.waitForOutput("\"index\": 3,"));
    std::filesystem::remove_all(station_.root() / "beam.mote");
    // What is in memory is drawn on: the film ends well, or says what is missing.
    frames.wait(std::chrono::milliseconds(2000));
    frames.signal(SIGTERM);
    const auto status = frames.wait();
    ASSERT_TRUE(status);
    EXPECT_NE(*status, 0);
    EXPECT_FALSE(std::filesystem::exists(videos() / "film.mp4"));
    EXPECT_GT(namesIn(videos() / ".film.mp4.frames").size(), 3U);
}

TEST_F(Films, AFrameThatFailsIsNamedAndTheOthersAreDrawn) {
    std::filesystem::copy(station_.root() / "beam.mote", station_.root() / "broken.mote");
    const auto step = station_.root() / "broken.mote" / "step-000000.h5";
    auto bytes = bytesOf(step);
    const auto place = bytes.size() / 50;  // in what is drawn: the octree lies first
    bytes[place] = static_cast<char>(bytes[place] ^ 4);
    std::ofstream(step, std::ios::binary) << bytes;
    const auto broken = beamView(64, 0, 4, "data/broken");
    const auto done =
        station_.frames(scriptOf({beamView(64), broken, beamView(64, 1), broken, beamView(64, 0, 3.0)}),
                        spawn({"--json"}), options());
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("views[1]"));
    EXPECT_THAT(done.errors, HasSubstr("2 frames are missing"));
    EXPECT_EQ(indicesIn(done.output), (std::set<int>{0, 2, 4}));
    EXPECT_THAT(namesIn(station_.out()), SizeIs(3));
}

TEST_F(Films, AFullDiskIsSaidAndLeavesNoVideo) {
    station_.startServer();
    auto limited = options();
    limited.fileSizeLimit = 2000;
    const auto done = runProcess(
        program("mote-frames"),
        arguments(turn(), videos() / "film.mp4", {"--connect", station_.connection().string()}), limited);
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("film.mp4"));
    EXPECT_FALSE(std::filesystem::exists(videos() / "film.mp4"));
}

TEST_F(Films, ThatAreInterruptedSayHowToGoOn) {
    auto words = arguments(turn(128, 100.0), videos() / "film.mp4", spawn({"--json"}));
    std::erase(words, "--quiet");
    Process frames(program("mote-frames"), words, options());
    ASSERT_TRUE(frames.waitForOutput("\"index\": 3,"));
    frames.signal(SIGINT);
    EXPECT_EQ(frames.wait(), 130);
    EXPECT_THAT(frames.errors(), HasSubstr("--resume"));
    EXPECT_FALSE(std::filesystem::exists(videos() / "film.mp4"));
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
}

// Films that are left with a server: they go on without client and without server, and are fetched whole.

class DetachedFilms : public testing::Test {
  protected:
    void SetUp() override { station_.startServer(); }

    std::filesystem::path script(int frames, int width = 64) const {
        std::string json = "{'fps': 25, 'view': {'width': " + std::to_string(width) +
                           ", 'height': 48, 'layers': [{'dataset': 'data/beam', 'particles': {}}]}, 'moves': "
                           "[{'turn': {'degrees': 360}, 'seconds': " +
                           std::to_string(frames / 25.0) + "}]}";
        std::replace(json.begin(), json.end(), '\'', '"');
        return station_.writeScript(json);
    }
    Finished run(std::vector<std::string> words) const {
        words.insert(words.end(), {"--connect", station_.connection().string(), "--quiet"});
        return runProcess(program("mote-frames"), words);
    }
    std::string detach(int frames, std::vector<std::string> more = {}) const {
        more.insert(more.end(), {script(frames).string(), "--detach"});
        const auto done = run(more);
        EXPECT_EQ(done.status, 0) << done.errors;
        EXPECT_EQ(done.output.size(), 17U) << done.output;
        return done.output.substr(0, 16);
    }
    proto::JobStatus await(const std::string& id) const {
        client::Connection connection(station_.connection(), {});
        return ended(connection, id);
    }
    Finished fetch(const std::string& id, std::vector<std::string> more) const {
        more.insert(more.end(), {"--fetch", id});
        return run(more);
    }

    /// And waits until it is.
    void cancel(const std::string& id) const {
        EXPECT_EQ(run({"--cancel", id}).status, 0);
        const auto followed = run({"--follow", id});
        EXPECT_EQ(followed.status, 1);
        EXPECT_THAT(followed.errors, HasSubstr("the job was cancelled"));
    }

    Station station_;
    TempDir folder_;
};

TEST_F(DetachedFilms, AreThePicturesThatARunMakes) {
    const auto id = detach(10);
    const auto job = await(id);
    ASSERT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    ASSERT_EQ(fetch(id, {"--out", (folder_ / "fetched").string()}).status, 0);
    ASSERT_EQ(run({script(10).string(), "--out", (folder_ / "drawn").string()}).status, 0);
    const auto names = namesIn(folder_ / "drawn");
    ASSERT_EQ(names.size(), 10U);
    EXPECT_EQ(namesIn(folder_ / "fetched"), names);
    for (const auto& name : names)
        EXPECT_EQ(bytesOf(folder_ / "fetched" / name), bytesOf(folder_ / "drawn" / name));
    // A video is made of them here, too.
    ASSERT_EQ(fetch(id, {"--video", (folder_ / "film.mp4").string()}).status, 0);
    EXPECT_GT(bytesOf(folder_ / "film.mp4").size(), 1000U);
}

TEST_F(DetachedFilms, AreEncodedWhereTheyAreMade) {
    std::string id;
    // What plays everywhere, unless the colours of single points are wanted.
    for (const std::string chroma : {"", "halved", "full"}) {
        const auto fetched = folder_ / ("fetched" + chroma + ".mp4"),
                   drawn = folder_ / ("drawn" + chroma + ".mp4");
        std::vector<std::string> words{"--video", "mp4", "--crf", "20"};
        if (!chroma.empty()) words.insert(words.end(), {"--chroma", chroma});
        id = detach(10, words);
        ASSERT_EQ(await(id).state(), proto::JobStatus::SUCCEEDED);
        ASSERT_EQ(fetch(id, {"--video", fetched.string()}).status, 0);
        ASSERT_EQ(run({script(10).string(), "--video", drawn.string(), "--crf", "20", "--chroma",
                       chroma.empty() ? "halved" : chroma})
                      .status,
                  0);
        EXPECT_EQ(bytesOf(fetched), bytesOf(drawn)) << chroma;
    }
    const auto pictures = fetch(id, {"--out", (folder_ / "pictures").string()});
    EXPECT_EQ(pictures.status, 1);
    EXPECT_THAT(pictures.errors, HasSubstr("mp4"));
}

/// Each frame is drawn once, though the server is killed in the midst of it.
TEST_F(DetachedFilms, OutliveTheirServer) {
    constexpr int frames = 200;
    const auto id = detach(frames);
    const auto folder = station_.connection().parent_path() / "state/jobs" / id / "film";
    std::map<std::string, std::filesystem::file_time_type> made;
    const auto look = [&] {
        for (const auto& name : namesIn(folder)) {
            if (name.front() == '.') continue;
            const auto time = std::filesystem::last_write_time(folder / name);
            EXPECT_EQ(made.emplace(name, time).first->second, time) << name << " was made twice";
        }
    };
    for (int i = 0; i < 2000 && namesIn(folder).size() < 20; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    look();
    ASSERT_GE(made.size(), 10U);
    ASSERT_LT(made.size(), frames - 20U) << "the film was done before the server could be killed";
    // Not the one that watches, which would start another: the one that draws.
    const auto file = wire::readConnectionFile(station_.connection());
    ASSERT_TRUE(file.ok());
    station_.server().signal(SIGKILL);
    ::kill(static_cast<pid_t>(file->pid()), SIGKILL);
    station_.server().wait();
    look();
    station_.startServer();
    const auto job = await(id);
    ASSERT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    look();
    EXPECT_EQ(made.size(), static_cast<std::size_t>(frames));
    ASSERT_EQ(fetch(id, {"--out", (folder_ / "fetched").string()}).status, 0);
    EXPECT_EQ(namesIn(folder_ / "fetched").size(), static_cast<std::size_t>(frames));
}

TEST_F(DetachedFilms, AreListedFollowedAndTriedAgain) {
    const auto id = detach(4, {"--job-time", "600"});
    const auto followed = run({"--follow", id});
    EXPECT_EQ(followed.status, 0) << followed.errors;
    const auto longer = detach(2000);
    cancel(longer);
    const auto again = run({"--retry", longer});
    ASSERT_EQ(again.status, 0) << again.errors;
    const auto second = again.output.substr(0, 16);
    EXPECT_NE(second, longer);
    cancel(second);
    const auto anew = run({"--retry", id});  // it succeeded, and is made again
    ASSERT_EQ(anew.status, 0) << anew.errors;
    const auto third = anew.output.substr(0, 16);
    EXPECT_EQ(run({"--follow", third}).status, 0);
    const auto list = run({"--list-jobs"});
    EXPECT_THAT(list.output,
                testing::MatchesRegex(third + "  succeeded[^\n]*\n" + second + "  cancelled[^\n]*\n" +
                                      longer + "  cancelled[^\n]*\n" + id + "  succeeded[^\n]*\n"));
    EXPECT_THAT(run({"--list-jobs", "--json"}).output, HasSubstr("\"timeLimitS\":600"));
}

TEST_F(DetachedFilms, ThatCannotBeFetchedSayWhy) {
    const auto none = fetch("0123456789abcdef", {"--out", (folder_ / "out").string()});
    EXPECT_EQ(none.status, 1);
    EXPECT_THAT(none.errors, HasSubstr("0123456789abcdef"));
    const auto id = detach(2000);
    const auto early = fetch(id, {"--out", (folder_ / "out").string()});
    EXPECT_EQ(early.status, 1);
    EXPECT_THAT(early.errors, testing::AnyOf(HasSubstr("queued"), HasSubstr("running"), HasSubstr("%")));
    cancel(id);
    EXPECT_EQ(fetch(id, {"--out", (folder_ / "out").string()}).status, 1);
    EXPECT_TRUE(namesIn(folder_ / "out").empty());
    const auto wrong = run({script(10, 63).string(), "--detach", "--video", "mp4"});
    EXPECT_TRUE(wrong.status == 1 || await(wrong.output.substr(0, 16)).state() == proto::JobStatus::FAILED);
}

}  // namespace
}  // namespace mote::test
