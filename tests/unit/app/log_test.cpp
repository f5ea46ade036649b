// SPDX-License-Identifier: GPL-3.0-or-later
//
// The log: lines of JSON that a machine reads, of bounded number and size, with nothing that a terminal
// obeys.
#include "server/log.h"

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "server/log/line_limit.h"
#include "server/log/log_line.h"
#include "tests/support/temp_dir.h"

namespace mote::server::log {
namespace {

using namespace std::chrono_literals;

google::protobuf::Struct parse(const std::string& line) {
    google::protobuf::Struct value;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(line, &value).ok()) << line;
    return value;
}

std::vector<std::string> linesOf(const std::filesystem::path& path) {
    std::vector<std::string> lines;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
}

TEST(LogLine, IsJsonWithFieldsWhateverIsInIt) {
    const std::string text = "\"a\" \\ \x1b]52;c;aGk=\x07 \xc2\x9b \n \xff end";
    const Line line{std::chrono::system_clock::time_point(1234567890123ms), Level::warning, session(7),
                    "closed: {}", text};
    const auto json = toJson(line);
    const auto value = parse(json);
    EXPECT_EQ(value.fields().at("time").string_value(), "2009-02-13T23:31:30.123Z");
    EXPECT_EQ(value.fields().at("level").string_value(), "warning");
    EXPECT_EQ(value.fields().at("session").number_value(), 7);
    EXPECT_EQ(value.fields().at("kind").string_value(), "closed: {}");
    EXPECT_FALSE(value.fields().contains("job"));
    for (const auto& shown : {json, toText(line)}) {
        EXPECT_EQ(shown.find_first_of("\x1b\x07\n"), std::string::npos) << shown;
        EXPECT_EQ(shown.find("\xc2\x9b"), std::string::npos) << shown;
        EXPECT_EQ(shown.find('\xff'), std::string::npos) << shown;
    }
    EXPECT_TRUE(toText(line).starts_with("2009-02-13T23:31:30.123Z warning session 7: \"a\""));
    const Line ofJob{line.time, Level::info, job("0123456789abcdef"), "x", "x"};
    EXPECT_EQ(parse(toJson(ofJob)).fields().at("job").string_value(), "0123456789abcdef");
}

TEST(LineLimit, LetsSoManyOfAKindThroughAndCountsTheOthers) {
    LineLimit limit(3, 60s);
    const LineLimit::Clock::time_point begin{};
    for (int i = 0; i < 10; ++i) EXPECT_EQ(limit.admit("one", begin + 1s * i), i < 3);
    EXPECT_TRUE(limit.admit("other", begin + 10s));
    EXPECT_TRUE(limit.over(begin + 59s).empty());
    const auto left = limit.over(begin + 60s);
    ASSERT_EQ(left.size(), 1u);
    EXPECT_EQ(left[0].kind, "one");
    EXPECT_EQ(left[0].count, 7u);
    EXPECT_TRUE(limit.over(begin + 70s).empty()) << "it was told already";
    EXPECT_TRUE(limit.admit("one", begin + 70s)) << "a new window";
}

class LogFile : public testing::Test {
  protected:
    ~LogFile() override { EXPECT_TRUE(setUp({}).ok()); }
    Settings settings() const {
        Settings settings;
        settings.json = true;
        settings.file = folder_ / "server.log";
        return settings;
    }
    test::TempDir folder_;
};

TEST_F(LogFile, IsForItsUserAloneAndHoldsWhatIsSaid) {
    ASSERT_TRUE(setUp(settings()).ok());
    info(session(3), "\"{}\" connected", "mote-view");
    error("cannot {}", "write");
    const auto lines = linesOf(settings().file);
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_EQ(parse(lines[0]).fields().at("text").string_value(), "\"mote-view\" connected");
    EXPECT_EQ(parse(lines[0]).fields().at("kind").string_value(), "\"{}\" connected");
    struct stat status {};
    ASSERT_EQ(::stat(settings().file.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(LogFile, OfOneKindSoManyLinesAreWrittenAndThenTheirNumber) {
    auto few = settings();
    few.linesAMinute = 5;
    ASSERT_TRUE(setUp(few).ok());
    for (int i = 0; i < 100; ++i) warn("again {}", i);
    info("another");
    EXPECT_EQ(linesOf(few.file).size(), 6u);
    finish();
    const auto lines = linesOf(few.file);
    ASSERT_EQ(lines.size(), 7u);
    EXPECT_EQ(parse(lines.back()).fields().at("text").string_value(), "95 more of: again {}");
}

TEST_F(LogFile, TakesBoundedSpace) {
    auto small = settings();
    small.fileSize = 1000;
    small.oldFiles = 2;
    small.linesAMinute = 1000;
    ASSERT_TRUE(setUp(small).ok());
    for (int i = 0; i < 200; ++i) info("line {}", i);
    std::uintmax_t bytes = 0;
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
        bytes += entry.file_size();
        ++files;
        for (const auto& line : linesOf(entry.path())) parse(line);
    }
    EXPECT_EQ(files, 3);
    EXPECT_LE(bytes, 3000u);
    EXPECT_EQ(parse(linesOf(small.file).back()).fields().at("text").string_value(), "line 199");
}

/// As the supervisor's after the process that serves is dead.
TEST_F(LogFile, IsOpenedAnewWhereAnotherProcessPutItAside) {
    auto small = settings();
    small.fileSize = 1000;
    ASSERT_TRUE(setUp(small).ok());
    const pid_t child = ::fork();
    if (child == 0) {
        reopen();
        for (int i = 0; i < 20; ++i) info("line {}", i);
        ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    reopen();
    info("the last");
    EXPECT_EQ(parse(linesOf(small.file).back()).fields().at("text").string_value(), "the last");
}

TEST_F(LogFile, ThatCannotBeOpenedIsAnError) {
    auto away = settings();
    std::ofstream(folder_ / "file") << "x";
    away.file = folder_ / "file" / "server.log";
    const auto opened = setUp(away);
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().where, "--log");
}

}  // namespace
}  // namespace mote::server::log
