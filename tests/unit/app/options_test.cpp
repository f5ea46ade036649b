// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/options.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "server/app/config_file.h"
#include "server/app/parse_size.h"
#include "server/app/server_option.h"
#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using Words = std::vector<std::string>;

std::variant<ServerSettings, int> parse(Words words) {
    words.insert(words.begin(), "mote-server");
    std::vector<const char*> pointers;
    for (const auto& word : words) pointers.push_back(word.c_str());
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    auto parsed = parseOptions(static_cast<int>(pointers.size()), pointers.data());
    testing::internal::GetCapturedStdout();
    testing::internal::GetCapturedStderr();
    return parsed;
}

const Words needed{"--root", "data=/data", "--state", "/state", "--connection", "/c.json"};

Words with(Words more) {
    more.insert(more.begin(), needed.begin(), needed.end());
    return more;
}

TEST(Options, AllOfThemAreTaken) {
    const auto parsed = parse(with(
        {"--root", "more=/more", "--listen", "unix", "--device", "egl", "--memory", "8G", "--threads", "3"}));
    const auto* settings = std::get_if<ServerSettings>(&parsed);
    ASSERT_NE(settings, nullptr);
    EXPECT_EQ(settings->roots, (Words{"data=/data", "more=/more"}));
    EXPECT_EQ(settings->stateDirectory, "/state");
    EXPECT_EQ(settings->connectionFile, "/c.json");
    EXPECT_EQ(settings->device, render::DeviceKind::egl);
    EXPECT_EQ(settings->memory, std::uint64_t{8} << 30);
    EXPECT_EQ(settings->threads, 3u);
}

TEST(Options, HelpIsSuccessAndWrongUsageIsTwo) {
    EXPECT_EQ(std::get<int>(parse({"--help"})), 0);
    for (const Words& words :
         {Words{}, Words{"--state", "/s"}, with({"--colour"}), with({"stray"}), with({"--threads", "many"}),
          with({"--threads", "-1"}), with({"--threads", "4097"}), with({"--threads", "3x"}),
          with({"--threads", "1", "--threads", "2"}), with({"--memory", "8X"}),
          with({"--listen", "tcp:127.0.0.1"}), with({"--listen", "pigeon"}), with({"--device", "gpu"}),
          with({"--root", "bad"}), with({"--root", "data=/other"}), with({"--config", "/absent.toml"})}) {
        const auto parsed = parse(words);
        ASSERT_TRUE(std::holds_alternative<int>(parsed)) << testing::PrintToString(words);
        EXPECT_EQ(std::get<int>(parsed), 2);
    }
}

TEST(Options, OfJobsAreTaken) {
    const auto unset = std::get<ServerSettings>(parse(needed));
    EXPECT_EQ(unset.runner, "local");
    EXPECT_FALSE(unset.allowUnconfinedJobs);
    const auto settings = std::get<ServerSettings>(
        parse(with({"--runner", "mpi", "--job-ranks", "4", "--jobs", "3", "--jobs-waiting", "20",
                    "--jobs-kept", "50", "--job-time", "3600", "--allow-unconfined-jobs"})));
    EXPECT_EQ(settings.runner, "mpi");
    EXPECT_EQ(settings.jobRanks, 4u);
    EXPECT_EQ(settings.jobs, 3u);
    EXPECT_EQ(settings.jobsWaiting, 20u);
    EXPECT_EQ(settings.jobsKept, 50u);
    EXPECT_EQ(settings.jobTime, 3600u);
    EXPECT_TRUE(settings.allowUnconfinedJobs);
    for (const Words& words :
         {with({"--runner", "pbs"}), with({"--runner", "mpi"}), with({"--job-ranks", "2"}),
          with({"--jobs", "0"}), with({"--job-time", "1h"})}) {
        EXPECT_EQ(std::get<int>(parse(words)), 2) << testing::PrintToString(words);
    }
}

TEST(Options, SilenceAndIdlenessAreSeconds) {
    using namespace std::chrono_literals;
    const auto unset = std::get<ServerSettings>(parse(needed));
    EXPECT_EQ(unset.silence, 30s);
    EXPECT_EQ(unset.idle, 12h);
    const auto settings = std::get<ServerSettings>(parse(with({"--silence", "120", "--idle", "0"})));
    EXPECT_EQ(settings.silence, 2min);
    EXPECT_EQ(settings.idle, 0s);
    for (const Words& words :
         {with({"--silence", "-1"}), with({"--silence", "30s"}), with({"--idle", "2592001"})})
        EXPECT_EQ(std::get<int>(parse(words)), 2) << testing::PrintToString(words);
}

TEST(Options, TcpIsAHostAndAPort) {
    EXPECT_FALSE(std::get<ServerSettings>(parse(with({"--listen", "unix"}))).tcp);
    const auto settings = std::get<ServerSettings>(parse(with({"--listen", "tcp:[::1]:0"})));
    ASSERT_TRUE(settings.tcp);
    EXPECT_EQ(settings.tcp->toString(), "tcp:[::1]:0");
}

TEST(Options, SizesAreByPowersOf1024) {
    EXPECT_EQ(*parseSize("1000000"), 1000000u);
    EXPECT_EQ(*parseSize("8G"), std::uint64_t{8} << 30);
    EXPECT_EQ(*parseSize("1.5GiB"), (std::uint64_t{3} << 30) / 2);
    EXPECT_EQ(*parseSize("512m"), std::uint64_t{512} << 20);
    EXPECT_EQ(*parseSize("4KB"), 4096u);
    for (const char* bad : {"", "G", "8X", "-1", "0", "8GG", "nan", "inf", "1e30", "8 G", "0x10", "8iB8"}) {
        EXPECT_FALSE(parseSize(bad).ok()) << bad;
    }
}

class ConfigFile : public testing::Test {
  protected:
    std::string write(const std::string& text) {
        std::ofstream(folder_ / "server.toml") << text;
        return (folder_ / "server.toml").string();
    }
    test::TempDir folder_;
};

TEST_F(ConfigFile, HoldsTheSameOptionsAndTheCommandLineWins) {
    const auto path = write(R"(
root = ["data=/file"]
state = "/file-state"
connection = "/file.json"
memory = "1G"
threads = 2
)");
    const auto fromFile = std::get<ServerSettings>(parse({"--config", path}));
    EXPECT_EQ(fromFile.roots, (Words{"data=/file"}));
    EXPECT_EQ(fromFile.stateDirectory, "/file-state");
    EXPECT_EQ(fromFile.threads, 2u);
    EXPECT_EQ(fromFile.memory, std::uint64_t{1} << 30);
    const auto both = std::get<ServerSettings>(parse(with({"--config", path, "--threads", "7"})));
    EXPECT_EQ(both.roots, (Words{"data=/data"}));
    EXPECT_EQ(both.stateDirectory, "/state");
    EXPECT_EQ(both.threads, 7u);
    EXPECT_EQ(both.memory, std::uint64_t{1} << 30);
}

TEST_F(ConfigFile, MistakesNameLineAndKey) {
    const std::pair<const char*, const char*> cases[] = {
        {"state = \"/s\"\ncolour = 3\n", "colour"},
        {"threads = \"two\"\n", "threads"},
        {"\n\nroot = \"data=/x\"\n", "server.toml:3"},
        {"root = [3]\n", "root"},
        {"state = \n", "server.toml:1"},
        {"\nthread = 3\n", "server.toml:2: there is no option \"thread\"; is \"threads\" meant?"},
        {"threads = 2.0\n", "\"threads\" must be a whole number"},
        {"memory = 1000\n", "\"memory\" must be a text"},
        {"[state]\nx = 1\n", "\"state\" must be a text"},
    };
    for (const auto& [text, word] : cases) {
        const auto options = readConfig(write(text));
        ASSERT_FALSE(options.ok()) << text;
        EXPECT_NE(options.error().toString().find(word), std::string::npos) << options.error().toString();
    }
    EXPECT_EQ(std::get<int>(parse(with({"--config", write("threads = 99999\n")}))), 2);
}

/// A value of the file that each option takes. An option that this does not know is a failure of the test
/// below.
std::string lineOf(const ServerOption& option) {
    const std::string name = option.name;
    if (option.isList()) return name + " = [\"data=/file\"]\n";
    if (option.isFlag()) return name + " = true\n";
    if (const auto* number = std::get_if<WholeNumber>(&option.target))
        return fmt::format("{} = {}\n", name, number->least);
    if (option.isNumber()) return name + " = 10\n";
    if (std::holds_alternative<Size>(option.target)) return name + " = \"8G\"\n";
    if (const auto* choice = std::get_if<Choice>(&option.target)) {
        return fmt::format("{} = \"{}\"\n", name, choice->words.back());
    }
    if (name == "device") return name + " = \"cpu\"\n";
    if (name == "listen") return name + " = \"unix\"\n";
    if (std::holds_alternative<HttpAddress>(option.target)) return name + " = \"unix:/file\"\n";
    return name + " = \"/file\"\n";
}

TEST_F(ConfigFile, HasAKeyForEachOption) {
    std::string all;
    for (const auto& option : serverOptions()) all += lineOf(option);
    const auto known = readConfig(write(all));
    ASSERT_TRUE(known.ok()) << known.error().toString();
    EXPECT_EQ(known->size(), serverOptions().size());
    const auto parsed = parse({"--config", write(all)});
    EXPECT_TRUE(std::holds_alternative<ServerSettings>(parsed));
}

/// What a configuration needs, of folders that are there.
std::string wellIn(const std::filesystem::path& folder) {
    return fmt::format("root = [\"data={0}/data\"]\nstate = \"{0}/state\"\nconnection = \"{0}/c.json\"\n",
                       folder.string());
}

/// What --check-config says on stderr.
std::string complaintOf(const std::string& path) {
    const char* words[] = {"mote-server", "--check-config", "--config", path.c_str()};
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto parsed = parseOptions(4, words);
    testing::internal::GetCapturedStdout();
    auto text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(std::get<int>(parsed), text.empty() ? 0 : 1);
    return text;
}

TEST_F(ConfigFile, WhatOnlyThePlaceKnowsIsCheckedInASentenceEach) {
    std::filesystem::create_directory(folder_ / "data");
    const auto well = wellIn(folder_ / "");
    EXPECT_EQ(complaintOf(write(well)), "");
    std::ofstream(folder_ / "file") << "x";
    const auto file = (folder_ / "file").string(), data = (folder_ / "data").string();
    const auto stateAt = [&](const std::string& place) {
        return fmt::format("root = [\"data={}\"]\nstate = \"{}\"\nconnection = \"{}/c.json\"\n", data, place,
                           data);
    };
    const std::pair<std::string, const char*> cases[] = {
        {well + "metrics = \"0.0.0.0:80\"\n", "\"0.0.0.0:80\" is neither unix:PATH nor 127.0.0.1:PORT"},
        {well + "metrics = \"/socket\"\n", "server.toml:4"},
        {well + "log = \"" + data + "\"\n", "--log: "},
        {well + "log = \"" + file + "/log\"\n", "is no folder"},
        {stateAt(file), "is no directory"},
        {stateAt(file + "/state"), "--state: "},
        {stateAt(data) + "job-ranks = 2\n", "--job-ranks: needs --runner mpi or slurm"},
        {stateAt(data) + "runner = \"mpi\"\n", "--job-ranks of 2 or more"},
    };
    for (const auto& [text, words] : cases) {
        const auto complaint = complaintOf(write(text));
        EXPECT_NE(complaint.find(words), std::string::npos) << text << complaint;
        EXPECT_EQ(std::ranges::count(complaint, '\n'), 1) << complaint;
    }
    std::filesystem::permissions(folder_ / "data", std::filesystem::perms::all);
    EXPECT_NE(complaintOf(write(stateAt(data))).find("others may write to it"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "state")) << "nothing is made";
}

TEST_F(ConfigFile, ARunnerWithoutItsProgramIsSaid) {
    std::filesystem::create_directory(folder_ / "data");
    const std::string before = std::getenv("PATH");
    setenv("PATH", folder_.path().c_str(), 1);
    const auto complaint = complaintOf(write(wellIn(folder_ / "") + "runner = \"slurm\"\n"));
    setenv("PATH", before.c_str(), 1);
    EXPECT_NE(complaint.find("--runner: \"slurm\" needs sbatch"), std::string::npos) << complaint;
}

TEST_F(ConfigFile, IsChecked) {
    const auto state =
        fmt::format("state = \"{0}/s\"\nconnection = \"{0}/c.json\"\n", folder_.path().string());
    std::filesystem::create_directory(folder_ / "data");
    const auto root = fmt::format("root = [\"data={}\"]\n", (folder_ / "data").string());
    EXPECT_EQ(std::get<int>(parse({"--check-config", "--config", write(root + state)})), 0);
    EXPECT_EQ(std::get<int>(parse({"--check-config", "--config", write(root + state + "colour = 1\n")})), 1);
    EXPECT_EQ(std::get<int>(parse({"--check-config", "--config", write(state)})), 1);
    std::filesystem::remove(folder_ / "data");
    EXPECT_EQ(std::get<int>(parse({"--check-config", "--config", write(root + state)})), 1);
}

TEST_F(ConfigFile, OfTheExampleIsRight) {
    const auto known = readConfig(MOTE_DEPLOY_FOLDER "/mote-server.toml");
    EXPECT_TRUE(known.ok()) << known.error().toString();
}

}  // namespace
}  // namespace mote::server
