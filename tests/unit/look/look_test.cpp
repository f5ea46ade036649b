// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a child that looks at foreign files may do, and what is said where it dies.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "preprocess/look/confined_child.h"
#include "preprocess/look/found.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

using prep::runConfined;
using testing::HasSubstr;

class ConfinedChild : public testing::Test {
  protected:
    const prep::CancelSignal signal_;
};

TEST_F(ConfinedChild, GivesItsStatus) {
    for (const int status : {0, 1, 75}) {
        const auto ended = runConfined([&] { return status; }, {}, signal_);
        ASSERT_TRUE(ended.ok());
        EXPECT_EQ(*ended, status);
    }
}

TEST_F(ConfinedChild, AnExceptionEndsItAndNobodyElse) {
    const pid_t own = ::getpid();
    const auto ended =
        runConfined([]() -> int { throw std::runtime_error("stdout is closed"); }, {}, signal_);
    ASSERT_EQ(::getpid(), own);
    ASSERT_TRUE(ended.ok());
    EXPECT_EQ(*ended, 1);
}

TEST_F(ConfinedChild, DeathIsASentence) {
    const auto ended = runConfined(
        [] {
            std::signal(SIGSEGV, SIG_DFL);  // sanitizers take it themselves
            std::raise(SIGSEGV);
            return 0;
        },
        {}, signal_);
    ASSERT_FALSE(ended.ok());
    EXPECT_EQ(ended.error().code, ErrorCode::corrupt);
    EXPECT_THAT(ended.error().message, HasSubstr("signal 11"));
}

TEST_F(ConfinedChild, TakesNoMoreTimeThanItIsGiven) {
    const auto ended = runConfined(
        [] {
            for (std::atomic<std::uint64_t> i{0};;) ++i;
            return 0;
        },
        {0, 1}, signal_);
    ASSERT_FALSE(ended.ok());
    EXPECT_EQ(ended.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(ended.error().message, HasSubstr("more than 1 s"));
}

TEST_F(ConfinedChild, ReadsAndDoesNotWrite) {
    if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, 1U) < 1) GTEST_SKIP() << "there is no Landlock";
    const TempDir folder;
    std::ofstream(folder / "read") << "here";
    const auto ended = runConfined(
        [&] {
            const bool reads = ::open((folder / "read").c_str(), O_RDONLY) >= 0;
            const bool writes = ::open((folder / "read").c_str(), O_WRONLY) >= 0;
            const bool makes = ::open((folder / "made").c_str(), O_CREAT | O_WRONLY, 0600) >= 0;
            const bool removes = ::unlink((folder / "read").c_str()) == 0;
            return (reads ? 1 : 0) + (writes ? 2 : 0) + (makes ? 4 : 0) + (removes ? 8 : 0);
        },
        {}, signal_);
    ASSERT_TRUE(ended.ok());
    EXPECT_EQ(*ended, 1);
}

// What is found, told to people and to scripts.

using prep::Found;
using prep::FoundColumn;
using testing::Not;

prep::Look anyLook() {
    prep::Look look;
    look.input = "a \"run\"\x1b\n.h5";
    Found found;
    found.kind = "particles";
    found.format = "csv";
    found.facts.push_back({"steps", std::uint64_t{2}, "steps", "2"});
    found.facts.push_back({"times", std::vector<double>{0.0, std::numeric_limits<double>::infinity()}});
    FoundColumn x{"x", "m"}, none{"y", "m"};
    for (const double value : {1.5, std::nan(""), -2.0}) x.take(value);
    none.take(std::numeric_limits<double>::infinity());
    found.columns.push_back(x);
    found.columns.push_back(none);
    found.notes.emplace_back("taken as m");
    look.found.push_back(found);
    return look;
}

TEST(FoundText, IsJson) {
    const std::string line = jsonLine(anyLook());
    google::protobuf::Struct read;
    ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(line, &read).ok()) << line;
    EXPECT_EQ(read.fields().at("input").string_value(), anyLook().input);
    const auto& found = read.fields().at("found").list_value().values(0).struct_value().fields();
    EXPECT_EQ(found.at("steps").number_value(), 2.0);
    EXPECT_TRUE(found.at("times").list_value().values(1).has_null_value());
    const auto& lines = found.at("lines").list_value();
    ASSERT_EQ(lines.values_size(), 1) << "what people are told";
    EXPECT_EQ(lines.values(0).struct_value().fields().at("label").string_value(), "steps");
    EXPECT_EQ(lines.values(0).struct_value().fields().at("text").string_value(), "2");
    const auto& columns = found.at("columns").list_value();
    const auto& x = columns.values(0).struct_value().fields();
    EXPECT_EQ(x.at("min").number_value(), -2.0);
    EXPECT_EQ(x.at("max").number_value(), 1.5);
    EXPECT_EQ(x.at("invalid").number_value(), 1.0);
    EXPECT_TRUE(columns.values(1).struct_value().fields().at("min").has_null_value());
}

TEST(FoundText, HasALineForEachThing) {
    const std::string text = lookText(anyLook());
    EXPECT_THAT(text, HasSubstr("steps    2\n"));
    EXPECT_THAT(text, HasSubstr("column   x from -2 to 1.5 m, 1 not finite\n"));
    EXPECT_THAT(text, HasSubstr("column   y has no finite value, 1 not finite\n"));
    EXPECT_THAT(text, HasSubstr("note     taken as m\n"));
    EXPECT_THAT(text, Not(HasSubstr("times")));
}

TEST(Look, IsWholeWhereNothingIsRefused) {
    auto look = anyLook();
    EXPECT_TRUE(look.whole());
    look.found.front().refused.emplace_back("is cut short");
    EXPECT_FALSE(look.whole());
    EXPECT_FALSE(prep::Look().whole());
}

}  // namespace
}  // namespace mote::test
