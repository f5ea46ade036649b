// SPDX-License-Identifier: GPL-3.0-or-later
//
// Looks at files by programs that behave as tests want: what is answered, how many run, and what ends them.
#include "server/jobs/look/look_runs.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <asio/io_context.hpp>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>

#include "protocol/base/utf8.h"
#include "server/jobs/look/look_answer.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* anyObject =
    R"({"input": "INPUT", "found": [{"kind": "particles", "format": "csv", "toldBy": "rows", "name": "e-", "steps": 3, )"
    R"("species": "electron", "counts": [1, 2], "ids": true, "lines": [{"label": "steps", "text": "3"}], )"
    R"("columns": [{"name": "x", "unit": "m", "min": -1.5, "max": 2, "invalid": 0}, )"
    R"({"name": "y", "unit": "m", "min": null, "max": null, "invalid": 7}], )"
    R"("notes": ["INPUT: is assumed"], "refused": []}], "refused": ["INPUT: a part is damaged"]})";

std::string objectOf(const std::string& path) {
    std::string text = anyObject;
    for (auto at = text.find("INPUT"); at != std::string::npos; at = text.find("INPUT"))
        text.replace(at, 5, path);
    return text;
}

class LookRunsTest : public testing::Test {
  protected:
    LookRunsTest() {
        for (const char* name : {"root", "bin", "state"}) fs::create_directory(folder_ / name);
        fs::permissions(folder_ / "state", fs::perms::owner_all);
        std::ofstream(folder_ / "root/a.csv") << "x\n1\n";
        settings_.stateDirectory = folder_ / "state";
        settings_.prep = folder_ / "bin/prep";
        settings_.supervisor = MOTE_BIN "/mote-supervise";
    }
    /// `script`: what the program does, a shell's words without other programs.
    void start(const std::string& script) {
        {
            std::ofstream program(settings_.prep);
            program << "#!/bin/sh\n" << script << "\n";
        }
        fs::permissions(settings_.prep, fs::perms::owner_all);
        looks_.reset();
        looks_.emplace(context_, settings_, *storage::Roots::parse({"data=" + (folder_ / "root").string()}));
        const auto started = looks_->start();
        ASSERT_TRUE(started.ok()) << started.error().toString();
    }
    void look(LookRuns::Ticket ticket, const std::string& input = "data/a.csv", const std::string& map = "") {
        proto::LookAtFile wanted;
        wanted.set_input(input);
        wanted.set_map(map);
        looks_->look(ticket, wanted, [this, ticket](Result<proto::Look> answer) {
            EXPECT_FALSE(answers_.contains(ticket));
            answers_.emplace(ticket, std::move(answer));
        });
    }
    /// Half a minute at most.
    void runUntil(const std::function<bool()>& wanted) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        while (!wanted() && std::chrono::steady_clock::now() < deadline) {
            context_.restart();
            context_.run_one_for(std::chrono::milliseconds(100));
        }
        EXPECT_TRUE(wanted());
    }
    Error failure(LookRuns::Ticket ticket) {
        runUntil([&] { return answers_.contains(ticket); });
        const auto& answer = answers_.at(ticket);
        EXPECT_FALSE(answer.ok());
        return answer.ok() ? Error{} : answer.error();
    }
    bool folderIsEmpty() const { return fs::is_empty(folder_ / "state/looks"); }
    std::string path() const { return (folder_ / "root/a.csv").string(); }

    test::TempDir folder_;
    JobSettings settings_;
    asio::io_context context_;
    std::map<LookRuns::Ticket, Result<proto::Look>> answers_;
    std::optional<LookRuns> looks_;
};

TEST_F(LookRunsTest, AnswersWhatTheProgramTells) {
    // No other program: cat is none of the shell's own.
    start("echo 'a word of a library'\nread -r line <<'END'\n" + objectOf(path()) +
          "\nEND\nprintf '%s\\n' \"$line\"\necho \"$*\"\nexit 1");
    look(1, "data/a.csv", "--help");
    runUntil([&] { return answers_.contains(1); });
    const auto& answer = answers_.at(1);
    ASSERT_TRUE(answer.ok()) << answer.error().toString();
    EXPECT_EQ(answer->input(), "data/a.csv");
    ASSERT_EQ(answer->found_size(), 1);
    const auto& found = answer->found(0);
    EXPECT_EQ(found.told_by(), "rows");
    EXPECT_EQ(found.lines(0).text(), "3");
    EXPECT_EQ(found.columns(0).min(), -1.5);
    EXPECT_FALSE(found.columns(1).has_min());
    EXPECT_EQ(found.columns(1).invalid(), 7U);
    EXPECT_EQ(found.facts().fields().size(), 4U);
    EXPECT_EQ(found.facts().fields().at("steps").number_value(), 3.0);
    EXPECT_EQ(found.notes(0), "data/a.csv: is assumed");
    EXPECT_EQ(answer->refused(0), "data/a.csv: a part is damaged");
    EXPECT_TRUE(folderIsEmpty());
}

TEST_F(LookRunsTest, AProgramThatEndsOtherwiseIsASentence) {
    start("kill -SEGV $$");
    look(1);
    EXPECT_EQ(failure(1).code, ErrorCode::corrupt);
    EXPECT_THAT(failure(1).toString(),
                HasSubstr("data/a.csv: is damaged in a way that its reader does not survive"));
    start("while :; do printf '%65536s' x; done");
    look(2);
    EXPECT_EQ(failure(2).code, ErrorCode::resourceExhausted);
    EXPECT_THAT(failure(2).message, HasSubstr("more than 8 MiB"));
    start("echo out of order >&2; exit 4");
    look(3);
    EXPECT_THAT(failure(3).toString(), HasSubstr("data/a.csv: cannot be looked at: out of order"));
    start("exit 0");
    look(4);
    EXPECT_EQ(failure(4).code, ErrorCode::corrupt);
    EXPECT_TRUE(folderIsEmpty());
}

TEST_F(LookRunsTest, FewRunAtOnceAndWhatIsCancelledMakesRoom) {
    start("while :; do :; done");
    for (LookRuns::Ticket ticket = 1; ticket <= 4; ++ticket) look(ticket);
    EXPECT_EQ(looks_->running(), LookRuns::mostAtOnce);
    looks_->cancel(3);  // which waits
    looks_->cancel(1);
    looks_->cancel(2);
    looks_->cancel(17);
    // Once both have ended the last one runs.
    runUntil([&] { return looks_->running() == 1; });
    looks_->cancel(4);
    runUntil([&] { return looks_->running() == 0; });
    EXPECT_TRUE(answers_.empty());
    EXPECT_TRUE(folderIsEmpty());
}

TEST_F(LookRunsTest, NoMoreWaitThanThereIsRoomFor) {
    start("while :; do :; done");
    const auto most = LookRuns::mostAtOnce + LookRuns::mostWaiting;
    for (LookRuns::Ticket ticket = 1; ticket <= most; ++ticket) look(ticket);
    EXPECT_TRUE(answers_.empty());
    look(most + 1);
    EXPECT_EQ(failure(most + 1).code, ErrorCode::resourceExhausted);
}

TEST_F(LookRunsTest, WhatCannotBeLookedAtRunsNothing) {
    start("exit 4");
    ASSERT_EQ(::mkfifo((folder_ / "root/pipe").c_str(), 0600), 0);
    look(1, "data/pipe");
    EXPECT_THAT(failure(1).toString(), HasSubstr("data/pipe: is neither a file nor a folder"));
    look(2, "data/gone.csv");
    EXPECT_EQ(failure(2).code, ErrorCode::notFound);
    look(3, "data/../a.csv");
    EXPECT_EQ(failure(3).code, ErrorCode::invalidArgument);
    look(4, "data/a.csv", std::string("a\0b", 3));
    EXPECT_EQ(failure(4).where, "map");
    look(5, "data/a.csv", std::string(5000, 'x'));
    EXPECT_EQ(failure(5).where, "map");
    EXPECT_EQ(looks_->running(), 0U);
}

TEST_F(LookRunsTest, WhatAnEarlierServerLeftGoes) {
    start("exit 0");
    looks_.reset();
    std::ofstream(folder_ / "state/looks/log") << "x";
    fs::create_directories(folder_ / "state/looks/7/deep");
    start("exit 0");
    EXPECT_TRUE(folderIsEmpty());
}

TEST(LookAnswer, DamagedTextIsAnErrorAndNoMore) {
    test::Random random(35);
    const std::string whole = "noise\n" + objectOf("/r/a.csv") + "\nmore noise\n";
    ASSERT_TRUE(lookAnswer(whole, "/r/a.csv", "data/a.csv").ok());
    int read = 0;
    for (int round = 0; round < 3000; ++round) {
        auto text = whole;
        for (auto edits = 1 + random.below(4); edits > 0; --edits) {
            const auto at = random.below(text.size());
            if (random.chance(0.3)) {
                text.erase(at, 1 + random.below(20));
            } else if (random.chance(0.3)) {
                text.insert(at, random.oneOf({"{", "[[[[", "\"", "null", "1e999", "\\ud800", "\xff", "\n"}));
            } else {
                text[at] = static_cast<char>(random.below(256));
            }
        }
        const auto answer = lookAnswer(text, "/r/a.csv", "data/a.csv");
        if (!answer.ok()) {
            EXPECT_EQ(answer.error().code, ErrorCode::corrupt);
            continue;
        }
        ++read;
        // Whatever it is now, it can be sent.
        proto::Look again;
        ASSERT_TRUE(again.ParseFromString(answer->SerializeAsString()));
        for (const auto& sentence : answer->refused()) EXPECT_TRUE(isUtf8(sentence));
    }
    EXPECT_GT(read, 100);
    EXPECT_FALSE(lookAnswer("", "", "a").ok());
    EXPECT_FALSE(lookAnswer("{\"input\":" + std::string(100'000, '['), "", "a").ok());
}

}  // namespace
}  // namespace mote::server
