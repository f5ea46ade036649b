// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/e2e/station.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <csignal>
#include <fstream>
#include <stdexcept>

namespace mote::test {
namespace {

void prepare(const std::vector<std::string>& arguments) {
    const auto done = runProcess(program("mote-prep"), arguments);
    if (done.status != 0) {
        throw std::runtime_error(
            fmt::format("mote-prep {} failed ({}): {}", arguments.front(), done.status, done.errors));
    }
}

class BeamFolder {
  public:
    BeamFolder() {
        const auto run = (folder_ / "run.h5").string();
        prepare({"synth", "beam", "--particles", "20000", "--steps", "2", "--seed", "1", "--out", run,
                 "--quiet"});
        prepare({"particles", run, "--axes", "x,px,y", "--out", (folder_ / "beam.mote").string(), "--quiet"});
    }
    const std::filesystem::path& path() const { return folder_.path(); }

  private:
    TempDir folder_;
};

std::string withQuotes(std::string json) {
    std::replace(json.begin(), json.end(), '\'', '"');
    return json;
}

}  // namespace

std::filesystem::path program(const std::string& name) {
    return std::filesystem::path(MOTE_BIN) / name;
}

const std::filesystem::path& beamFolder() {
    static const BeamFolder folder;
    return folder.path();
}

Station::Station() {
    std::filesystem::create_directory(temporary());
    std::filesystem::copy(beamFolder(), root(), std::filesystem::copy_options::recursive);
}

Station::~Station() {
    if (!server_) return;
    server_->signal(SIGTERM);
    server_->wait();
}

std::vector<std::string> Station::serverArguments() const {
    return {"--state", (folder_ / "state").string(), "--connection", connection().string()};
}

void Station::startServer(const std::string& name) {
    auto words = serverArguments();
    words.insert(words.end(), {"--root", "data=" + root().string()});
    server_ = std::make_unique<Process>(program(name), words);
    awaitServer();
}

void Station::startRanks(int ranks, const std::vector<std::filesystem::path>& otherRoots) {
    auto roots = otherRoots;
    roots.insert(roots.begin(), static_cast<std::size_t>(ranks), root());
    // By a shell, which takes its rank's: mpirun of Open MPI 5.0.7 crashes where ":" parts several programs.
    std::vector<std::string> words{
        "-n",
        std::to_string(roots.size()),
        "/bin/sh",
        "-c",
        "roots=$1; shift; shift $OMPI_COMM_WORLD_RANK; data=$1; "
        "shift $((roots - OMPI_COMM_WORLD_RANK)); exec \"$@\" --root \"data=$data\"",
        "sh",
        std::to_string(roots.size())};
    for (const auto& each : roots) words.push_back(each.string());
    words.push_back(program("mote-server").string());
    const auto arguments = serverArguments();
    words.insert(words.end(), arguments.begin(), arguments.end());
    server_ = std::make_unique<Process>("/usr/bin/mpirun", words, mpiEnvironment(folder_.path()));
    awaitServer();
}

void Station::awaitServer() {
    if (server_->waitForOutput("ready")) return;
    server_->wait();
    throw std::runtime_error("mote-server is not ready: " + server_->errors());
}

std::filesystem::path Station::writeScript(const std::string& json) const {
    const auto path = folder_ / "script.json";
    std::ofstream(path) << withQuotes(json);
    return path;
}

std::vector<std::string> Station::framesArguments(const std::string& script,
                                                  const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{writeScript(script).string(), "--out", out().string()};
    const bool spawns = std::find(more.begin(), more.end(), "--spawn") != more.end();
    if (!spawns) arguments.insert(arguments.end(), {"--connect", connection().string()});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

Finished Station::frames(const std::string& script, const std::vector<std::string>& more,
                         const ProcessOptions& options) const {
    return runProcess(program("mote-frames"), framesArguments(script, more), options);
}

std::string beamView(int width, int step, double distance, const std::string& dataset) {
    return fmt::format(
        "{{'width': {}, 'height': {}, 'camera': {{'eye': [0, 0, {}], 'target': [0, 0, 0], 'up': [0, 1, 0]}}, "
        "'layers': [{{'dataset': '{}', 'step': {}, 'particles': {{}}}}]}}",
        width, width * 3 / 4, distance, dataset, step);
}

std::string scriptOf(const std::vector<std::string>& views) {
    return fmt::format("{{'views': [{}]}}", fmt::join(views, ", "));
}

std::string bytesOf(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::string> namesIn(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

using client::Connection;

std::vector<std::string> datasets(Connection& connection) {
    const auto catalogue =
        answer<proto::Catalogue>(connection, [&](auto reply) { connection.listDatasets(reply); });
    std::vector<std::string> names;
    if (catalogue.ok()) {
        for (const auto& entry : catalogue->datasets()) names.push_back(entry.name());
    }
    return names;
}

std::string submit(Connection& connection, const proto::JobRequest& request) {
    const auto job =
        answer<proto::JobStatus>(connection, [&](auto reply) { connection.submitJob(request, reply); });
    EXPECT_TRUE(job.ok()) << job.error().toString();
    return job.ok() ? job->id() : "";
}

proto::JobStatus reached(Connection& connection, const std::string& id, proto::JobStatus::State state,
                         std::vector<double>* progress) {
    proto::JobStatus last;
    const auto take = [&](const proto::JobStatus& status) {
        if (status.id() != id) return;
        last = status;
        if (progress != nullptr) progress->push_back(status.progress());
    };
    connection.onJob(take);
    const auto jobs = answer<proto::Jobs>(connection, [&](auto reply) { connection.watchJobs(reply); });
    EXPECT_TRUE(jobs.ok());
    // What changed after the answer has come through the listener already and is newer.
    if (jobs.ok() && last.id().empty()) {
        for (const auto& job : jobs->jobs()) take(job);
    }
    EXPECT_TRUE(eventually(connection, [&] { return last.state() >= state; }));
    connection.onJob({});
    return last;
}

}  // namespace mote::test
