// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is said of a command line that is wrong: one sentence that names what was mistyped.
#include "protocol/cli/command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace mote::cli {
namespace {

/// A program with two subcommands, of which the first has a group, and what it says of `words` on stderr.
std::string saidOf(std::vector<const char*> words) {
    const Program program("Looks at runs.", "look");
    const auto command = program.command();
    command.requireOneSubcommand();
    const auto particles = command.subcommand("particles", "Plots");
    std::string input, axes, connect, spawn;
    std::uint64_t memory = 0;
    particles.option("INPUT", input).required();
    particles.option("--axes", axes).required();
    particles.option("--memory", memory).size(1, std::uint64_t{1} << 40);
    const auto server = particles.group("server", "Which answers");
    server.option("--connect", connect);
    server.option("--spawn", spawn);
    server.requireOneOption();
    command.subcommand("volume", "Volumes");
    words.insert(words.begin(), "look");
    testing::internal::CaptureStderr();
    const auto status = program.parse(static_cast<int>(words.size()), words.data());
    const auto said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(status, status ? std::optional(2) : std::nullopt);
    EXPECT_EQ(status.has_value(), !said.empty());
    return said.substr(0, said.find('\n'));
}

TEST(CommandLine, NamesWhatWasMistyped) {
    EXPECT_EQ(saidOf({}), "look: A subcommand is required");
    EXPECT_EQ(saidOf({"particels"}), "look: there is no subcommand particels; near it: particles");
    EXPECT_EQ(saidOf({"qqq"}), "look: there is no subcommand qqq");
    EXPECT_EQ(saidOf({"particles", "run.h5", "--axis", "x,px,y"}),
              "look: --axis: there is no such option; near it: --axes");
    EXPECT_EQ(saidOf({"particles", "run.h5", "--axes", "x", "--spwan=data=plots"}),
              "look: --spwan: there is no such option; near it: --spawn");
    EXPECT_EQ(saidOf({"particles", "run.h5", "other.h5", "--axes", "x", "--spawn", "a"}),
              "look: \"other.h5\" is one word too many");
}

TEST(CommandLine, SaysWhatIsMissing) {
    EXPECT_EQ(saidOf({"particles", "--axes", "x", "--spawn", "a"}), "look: INPUT is required");
    EXPECT_EQ(saidOf({"particles", "run.h5", "--axes", "x"}), "look: --connect or --spawn is required");
    EXPECT_EQ(saidOf({"particles", "run.h5", "--axes", "x", "--connect", "a", "--spawn", "b"}),
              "look: only one of --connect and --spawn can be given");
    EXPECT_EQ(saidOf({"particles", "run.h5", "--axes", "x", "--spawn", "a"}), "");
}

TEST(CommandLine, SizesAreWrittenInTheirUnits) {
    const auto memory = [](const char* size) {
        return saidOf({"particles", "run.h5", "--axes", "x", "--spawn", "a", "--memory", size});
    };
    EXPECT_EQ(memory("8G"), "");
    EXPECT_THAT(memory("lots"), testing::HasSubstr("--memory: \"lots\" is no size; one is 512M or 8G"));
}

}  // namespace
}  // namespace mote::cli
