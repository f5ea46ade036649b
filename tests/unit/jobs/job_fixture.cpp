// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/jobs/job_fixture.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>

namespace mote::server {
namespace {

constexpr std::chrono::seconds kPatience(30);  // a limit for a broken test, not a time that any test takes

}  // namespace

JobTest::JobTest() {
    auto pattern = (std::filesystem::temp_directory_path() / "mote-jobs-XXXXXX").string();
    directory_ = mkdtemp(pattern.data());
    root_ = directory_ / "root";
    std::filesystem::create_directory(root_);
}

JobTest::~JobTest() {
    // A failed test must leave no process behind: cancel what lives and wait for its end.
    if (queue_) {
        for (const auto& status : queue_->list()) {
            if (!queue_->cancel(status.id()).ok()) continue;
            waitUntil(status.id(), [](const auto& now) { return now.state() > State::RUNNING; });
        }
    }
    killServer();
    for (const auto& [name, fd] : fifos_) close(fd);
    std::error_code code;
    std::filesystem::remove_all(directory_, code);
}

JobSettings JobTest::settings() const {
    JobSettings settings;
    settings.stateDirectory = directory_ / "state";
    settings.prep = MOTE_FAKE_PREP;
    settings.frames = MOTE_FAKE_PREP;
    settings.supervisor = MOTE_BIN "/mote-supervise";
    settings.roots = {"data=" + root_.string()};
    return settings;
}

void JobTest::startServer(JobSettings settings) {
    killServer();
    context_ = std::make_unique<asio::io_context>();
    queue_ = std::make_unique<JobQueue>(*context_, std::move(settings));
    queue_->onChange([this](const proto::JobStatus& status) { changes_.push_back(status); });
    const auto started = queue_->start();
    ASSERT_TRUE(started.ok()) << started.error().toString();
}

void JobTest::killServer() {
    queue_.reset();
    context_.reset();
}

proto::JobRequest JobTest::request(const std::string& script, const std::string& output) const {
    proto::JobRequest request;
    request.set_title(script);
    request.set_output(output);
    request.mutable_synth_beam()->set_particles(10);
    request.mutable_synth_beam()->set_steps(1);
    return request;
}

std::string JobTest::submit(const std::string& script, const std::string& output) {
    const auto status = queue_->submit(request(script, output));
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return status.ok() ? status.value().id() : std::string();
}

proto::JobRequest JobTest::filmRequest(const std::string& script) const {
    proto::JobRequest request;
    request.set_title(script);
    auto& view = *request.mutable_film()->mutable_script()->add_views();
    view.set_width(64);
    view.set_height(48);
    return request;
}

std::string JobTest::submitFilm(const std::string& script) {
    const auto status = queue_->submit(filmRequest(script));
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return status.ok() ? status.value().id() : std::string();
}

void JobTest::releaseFilm(const std::string& id, const std::string& name) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!std::filesystem::exists(filmFile(id, name)) && std::chrono::steady_clock::now() < end) settle();
    // Blocks until somebody waits there.
    const int fifo = open(filmFile(id, name).c_str(), O_WRONLY | O_CLOEXEC);
    ASSERT_GE(fifo, 0) << name;
    EXPECT_EQ(write(fifo, "g", 1), 1);
    close(fifo);
}

Result<ArtifactPiece> JobTest::fetch(const proto::FetchFilm& request) {
    std::optional<Result<ArtifactPiece>> answer;
    queue_->fetchArtifact(request, [&](Result<ArtifactPiece> piece) { answer.emplace(std::move(piece)); });
    EXPECT_FALSE(answer) << "it is never told from within the call";
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!answer && std::chrono::steady_clock::now() < deadline) {
        context_->restart();
        context_->run_one_until(deadline);
    }
    if (!answer) return Error{ErrorCode::internal, "", "no answer"};
    return *std::move(answer);
}

Result<ArtifactPiece> JobTest::fetchPicture(const std::string& id, std::uint32_t frame, std::uint64_t begin) {
    proto::FetchFilm request;
    request.set_id(id);
    request.set_frame(frame);
    request.set_begin(begin);
    return fetch(request);
}

Result<ArtifactPiece> JobTest::fetchVideo(const std::string& id, std::uint64_t begin) {
    proto::FetchFilm request;
    request.set_id(id);
    request.set_begin(begin);
    return fetch(request);
}

proto::JobStatus JobTest::waitUntil(const std::string& id,
                                    const std::function<bool(const proto::JobStatus&)>& wanted) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < deadline) {
        const auto status = queue_->find(id);
        if (!status.ok()) {
            ADD_FAILURE() << status.error().toString();
            return {};
        }
        if (wanted(status.value())) return status.value();
        context_->restart();
        context_->run_one_until(deadline);
    }
    const auto last = queue_->find(id);
    ADD_FAILURE() << "waited in vain; job " << (last.ok() ? last.value().ShortDebugString() : "gone");
    return last.ok() ? last.value() : proto::JobStatus();
}

proto::JobStatus JobTest::waitForState(const std::string& id, proto::JobStatus::State state) {
    return waitUntil(id, [&](const auto& status) { return status.state() == state; });
}

proto::JobStatus JobTest::waitForPhase(const std::string& id, const std::string& phase) {
    return waitUntil(id, [&](const auto& status) { return status.phase() == phase; });
}

void JobTest::settle() {
    context_->restart();
    context_->poll();
}

bool JobTest::comes(const std::function<bool()>& wanted) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!wanted()) {
        if (std::chrono::steady_clock::now() >= deadline) return false;
        settle();
        std::this_thread::yield();
    }
    return true;
}

void JobTest::makeFifo(const std::string& name) {
    const auto path = root_ / name;
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    fifos_.emplace_back(name, open(path.c_str(), O_RDWR | O_CLOEXEC));
}

void JobTest::release(const std::string& name) {
    for (const auto& [known, fd] : fifos_) {
        if (known == name) {
            ASSERT_EQ(write(fd, "g", 1), 1);
        }
    }
}

void waitForEnd(int pid) {
    const int process = static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
    if (process < 0) return;  // gone
    pollfd end{process, POLLIN, 0};
    EXPECT_EQ(poll(&end, 1, 30'000), 1) << "process " << pid << " still lives";
    close(process);
}

}  // namespace mote::server
