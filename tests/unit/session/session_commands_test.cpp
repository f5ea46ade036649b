// SPDX-License-Identifier: GPL-3.0-or-later
//
// Commands: datasets, jobs; and how a server begins and ends.
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "storage/manifest.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

class SessionCommands : public SessionFixture {
  protected:
    /// A dataset as the catalogue sees it, published by one rename.
    void publish(const std::string& name, const std::string& input) {
        proto::Manifest manifest;
        manifest.set_kind("particles");
        manifest.set_format(storage::formatVersion);
        manifest.set_title("a plot");
        auto& particles = *manifest.mutable_particles();
        for (const char* axis : {"x", "y", "z"}) {
            auto& added = *particles.add_axes();
            added.set_name(axis);
            added.set_unit("m");
            added.set_min(-1);
            added.set_max(1);
        }
        particles.set_density_min(1);
        particles.set_density_max(2);
        particles.set_volume_level(5);
        particles.set_leaf_capacity(64);
        particles.set_max_level(10);
        auto& step = *particles.add_steps();
        step.set_file("step-000000.h5");
        step.set_digest("step-000000.digest");
        step.set_particles(5);
        step.set_total_weight(5);
        for (int i = 0; i < storage::densityHistogramBins; ++i) step.add_density_histogram(i == 0 ? 5 : 0);
        for (const char* file : {"step-000000.h5", "step-000000.digest"}) {
            auto& entry = *manifest.add_files();
            entry.set_name(file);
            entry.set_size(1);
            entry.set_xxh3_128(std::string(32, '0'));
        }
        manifest.mutable_request()->mutable_particles()->add_inputs(input);
        for (const char* axis : {"x", "y", "z"})
            manifest.mutable_request()->mutable_particles()->add_axes(axis);
        const fs::path hidden = folder_ / "data" / ("." + name);
        fs::create_directories(hidden);
        const auto written = storage::writeManifest(hidden, manifest);
        ASSERT_TRUE(written.ok()) << written.error().toString();
        fs::rename(hidden, folder_ / "data" / (name + ".mote"));
    }

    /// A socket that nobody listens on, as a killed server leaves it.
    static void leaveSocket(const fs::path& path) {
        const int descriptor = ::socket(AF_UNIX, SOCK_STREAM, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.native().copy(address.sun_path, sizeof(address.sun_path) - 1);
        ASSERT_EQ(::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
        ::close(descriptor);
        ASSERT_TRUE(fs::is_socket(path));
    }

    static proto::ClientMessage describe(const std::string& dataset) {
        proto::ClientMessage message;
        message.mutable_describe()->set_dataset(dataset);
        return message;
    }
};

TEST_F(SessionCommands, ListShowsWhatIsThereNow) {
    start();
    const auto one = client();
    proto::ClientMessage list;
    list.mutable_list_datasets();
    EXPECT_EQ(one->ask(list).message.catalogue().datasets_size(), 0);
    publish("beam", "run.h5");
    const auto reply = one->ask(list);
    ASSERT_EQ(reply.message.catalogue().datasets_size(), 1);
    EXPECT_EQ(reply.message.catalogue().datasets(0).name(), "data/beam");
    EXPECT_EQ(reply.message.catalogue().datasets(0).steps(), 1u);
    EXPECT_EQ(reply.message.catalogue().datasets(0).particles(), 5u);
}

TEST_F(SessionCommands, NewDatasetIsAnnounced) {
    settings_.rescanInterval = std::chrono::milliseconds(5);
    start();
    const auto one = client();
    publish("beam", "run.h5");
    const auto told = one->receive([](const auto& message) {
        return message.has_catalogue() && message.catalogue().datasets_size() == 1;
    });
    EXPECT_EQ(told.message.reply_to(), 0u);
    fs::remove_all(folder_ / "data" / "beam.mote");
    one->receive([](const auto& message) {
        return message.has_catalogue() && message.catalogue().datasets_size() == 0;
    });
}

TEST_F(SessionCommands, DescriptionNamesInputsBeneathTheRoot) {
    start();
    std::ofstream(folder_ / "data" / "run.h5") << "x";
    publish("near", "run.h5");
    publish("gone", "absent.h5");
    publish("beyond", "../elsewhere.h5");
    std::ofstream(folder_ / "elsewhere.h5") << "x";
    const auto one = client();
    const auto near = one->ask(describe("data/near")).message.description();
    EXPECT_EQ(near.dataset(), "data/near");
    EXPECT_EQ(near.manifest().title(), "a plot");
    ASSERT_TRUE(near.has_replot());
    EXPECT_EQ(near.replot().particles().inputs(0), "data/run.h5");
    EXPECT_EQ(near.replot().output(), "");
    EXPECT_FALSE(one->ask(describe("data/gone")).message.description().has_replot());
    EXPECT_FALSE(one->ask(describe("data/beyond")).message.description().has_replot());
}

TEST_F(SessionCommands, DescriptionOfADatasetPublishedThisMoment) {
    settings_.rescanInterval = std::chrono::hours(1);
    start();
    const auto one = client();
    proto::ClientMessage list;
    list.mutable_list_datasets();
    one->ask(list);
    publish("late", "run.h5");
    EXPECT_EQ(one->ask(describe("data/late")).message.description().dataset(), "data/late");
}

TEST_F(SessionCommands, UnknownNamesAreErrorsThatNameThem) {
    start();
    const auto one = client();
    const auto dataset = one->ask(describe("data/nothing")).message.failure();
    EXPECT_EQ(dataset.code(), "not_found");
    EXPECT_NE(dataset.message().find("data/nothing"), std::string::npos);
    EXPECT_FALSE(dataset.fatal());
    proto::ClientMessage cancel;
    cancel.mutable_cancel_job()->set_id("none");
    EXPECT_EQ(one->ask(cancel).message.failure().code(), "not_found");
    proto::ClientMessage submit;
    submit.mutable_submit_job()->mutable_job()->mutable_particles();
    const auto refused = one->ask(submit).message.failure();
    EXPECT_EQ(refused.code(), "invalid_argument");
    EXPECT_TRUE(refused.where().starts_with("job")) << refused.ShortDebugString();
}

/// Jobs run /bin/false and fail.
TEST_F(SessionCommands, JobsAreTriedAgainAndListedInPages) {
    start();
    std::ofstream(folder_ / "data" / "run.h5") << "x";
    const auto one = client();
    proto::ClientMessage watch;
    watch.mutable_watch_jobs();
    one->ask(watch);
    proto::ClientMessage submit;
    auto& job = *submit.mutable_submit_job()->mutable_job();
    job.set_output("data/plot.mote");
    job.mutable_particles()->add_inputs("data/run.h5");
    for (const char* axis : {"x", "y", "z"}) job.mutable_particles()->add_axes(axis);
    submit.mutable_submit_job()->set_time_limit_s(77);
    const auto first = one->ask(submit).message.job();
    EXPECT_EQ(first.time_limit_s(), 77U);
    one->receive([&](const auto& message) {
        return message.job().id() == first.id() && message.job().state() == proto::JobStatus::FAILED;
    });
    proto::ClientMessage retry;
    retry.mutable_retry_job()->set_id(first.id());
    const auto second = one->ask(retry).message.job();
    EXPECT_NE(second.id(), first.id());
    EXPECT_EQ(second.time_limit_s(), 77U);
    proto::ClientMessage list;
    list.mutable_list_jobs()->set_first(1);
    const auto page = one->ask(list).message.jobs();
    EXPECT_EQ(page.total(), 2U);
    ASSERT_EQ(page.jobs_size(), 1);
    EXPECT_EQ(page.jobs(0).id(), first.id());
    retry.mutable_retry_job()->set_id("0123456789abcdef");
    EXPECT_EQ(one->ask(retry).message.failure().code(), "not_found");
}

/// The job runs /bin/false: that it fails is what its changes must say.
TEST_F(SessionCommands, JobsAreSubmittedAndWatched) {
    start();
    std::ofstream(folder_ / "data" / "run.h5") << "x";
    const auto watcher = client();
    const auto one = client();
    proto::ClientMessage watch;
    watch.mutable_watch_jobs();
    const auto before = watcher->ask(watch);
    ASSERT_TRUE(before.message.has_jobs());
    EXPECT_EQ(before.message.jobs().jobs_size(), 0);
    proto::ClientMessage submit;
    auto& job = *submit.mutable_submit_job()->mutable_job();
    job.set_output("data/plot.mote");
    job.mutable_particles()->add_inputs("data/run.h5");
    for (const char* axis : {"x", "y", "z"}) job.mutable_particles()->add_axes(axis);
    const auto submitted = one->ask(submit);
    ASSERT_TRUE(submitted.message.has_job()) << submitted.message.ShortDebugString();
    const auto id = submitted.message.job().id();
    const auto ended = watcher->receive([&](const auto& message) {
        return message.job().id() == id && message.job().state() == proto::JobStatus::FAILED;
    });
    EXPECT_FALSE(ended.message.job().error().empty());
    EXPECT_EQ(one->ask(watch).message.jobs().jobs_size(), 1);
}

TEST_F(SessionCommands, AnswersKeepTheOrderOfTheQuestions) {
    start();
    const auto one = client();
    for (std::uint64_t request = 100; request < 140; ++request) {
        proto::ClientMessage message = describe("data/x" + std::to_string(request));
        message.set_request(request);
        one->send(message);
    }
    for (std::uint64_t request = 100; request < 140; ++request) {
        const auto reply = one->receive([](const auto& message) { return message.reply_to() != 0; });
        EXPECT_EQ(reply.message.reply_to(), request);
    }
}

TEST_F(SessionCommands, ServerThatEndsSaysSoAndLeavesNothing) {
    start();
    control_->closeGate();
    const auto busy = client();
    busy->setView(1, 64);
    control_->awaitBegun(1);
    const auto idle = client();
    const auto path = socket();
    struct stat status {};
    ASSERT_EQ(::stat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
    server_->stop();
    for (auto* session : {busy.get(), idle.get()}) {
        const auto last = session->receive([](const auto& message) { return message.has_failure(); });
        EXPECT_EQ(last.message.failure().where(), "server");
        EXPECT_TRUE(last.message.failure().fatal());
        EXPECT_TRUE(session->atEnd());
    }
    thread_.join();
    server_.reset();  // with a picture at the closed gate: it is stopped
    EXPECT_FALSE(fs::exists(path));
    EXPECT_FALSE(fs::exists(settings_.connectionFile));
}

TEST_F(SessionCommands, LiveServerIsNotDisturbedAndADeadOnesSocketIsReplaced) {
    start();
    const auto make = [](const server::ServerSettings& settings) {
        return server::Server(settings,
                              [] { return std::make_unique<FakeDevice>(std::make_shared<FakeControl>()); });
    };
    server::ServerSettings second = settings_;
    second.connectionFile = folder_ / "other.json";
    EXPECT_EQ(make(second).start().error().code, ErrorCode::alreadyExists);
    second = settings_;
    second.stateDirectory = folder_ / "state2";
    const auto sameFile = make(second).start();
    EXPECT_EQ(sameFile.error().code, ErrorCode::alreadyExists);
    EXPECT_NE(sameFile.error().toString().find("connection.json"), std::string::npos);
    client()->barrier();
    const auto path = socket();
    stop();
    // What a killed server leaves behind.
    { std::ofstream(settings_.connectionFile) << "{}"; }
    leaveSocket(path);
    start();
    client()->barrier();
}

TEST_F(SessionCommands, StateDirectoryWithALongPathStillHasASocket) {
    settings_.stateDirectory = folder_ / std::string(120, 's');
    start();
    EXPECT_LE(socket().native().size(), wire::maxSocketPath);
    client()->barrier();
    const auto path = socket();
    stop();
    EXPECT_FALSE(fs::exists(path.parent_path()));
}

TEST_F(SessionCommands, WhatKeepsAServerFromItsWorkIsOneErrorThatNamesIt) {
    const auto errorOf = [&](const server::ServerSettings& settings) {
        const auto status = server::Server(settings, []() -> std::unique_ptr<render::Device> {
                                throw render::DeviceError("there is no GPU");
                            }).start();
        return status.ok() ? std::string() : status.error().toString();
    };
    EXPECT_NE(errorOf(settings_).find("there is no GPU"), std::string::npos);
    auto wrong = settings_;
    wrong.roots = {"data=" + (folder_ / "absent").string()};
    EXPECT_NE(errorOf(wrong).find("absent"), std::string::npos);
    EXPECT_FALSE(fs::exists(settings_.connectionFile));
}

}  // namespace
}  // namespace mote::test
