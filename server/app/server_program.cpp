// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/server_program.h"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <semaphore>
#include <thread>
#include <utility>

#include "protocol/base/complain.h"
#include "server/app/options.h"
#include "server/app/server.h"
#include "server/app/startup_report.h"
#include "server/app/supervisor.h"
#include "server/data/data_memory.h"
#include "server/frames/picture_maker.h"
#include "server/log.h"
#include "server/render/ranks/ranked_device.h"
#include "server/render/ranks/ranks.h"
#include "server/session/token.h"
#include "storage/blocks/mapped_file.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;

constexpr int failed = 1;
// The promise is 10 s from the signal; a driver that hangs must not break it.
constexpr auto endTimeout = 8s;

std::filesystem::path programBeside(const char* name) {
    std::error_code code;
    return std::filesystem::read_symlink("/proc/self/exe", code).parent_path() / name;
}

Status setUpLog(const ServerSettings& settings) {
    // What a client sends must not fill the log; it becomes an Error that we report.
    google::protobuf::SetLogHandler(nullptr);
    log::Settings log;
    log.json = settings.logFormat == "json";
    log.file = settings.logFile;
    log.fileSize = settings.logSize;
    log.oldFiles = settings.logFiles;
    return log::setUp(log);
}

int fail(std::string_view why) {
    complain("mote-server", why);
    return failed;
}

/// Ends the process where `finished` is not released in time.
class Watchdog {
  public:
    void start() {
        thread_ = std::thread([this] {
            if (finished_.try_acquire_for(endTimeout)) return;
            log::error("the device does not end; leaving it behind");
            std::_Exit(0);
        });
    }
    ~Watchdog() {
        finished_.release();
        if (thread_.joinable()) thread_.join();
    }

  private:
    std::binary_semaphore finished_{0};
    std::thread thread_;
};

/// What nobody expected ends the process by a signal, and the supervisor starts another.
void runOrDie(Server& server) noexcept {
    server.run();
}

/// Serves until a signal ends it. Returns the exit code.
int serve(const ServerSettings& settings, DeviceFactory device, bool again) {
    Watchdog watchdog;
    Server server(settings, std::move(device));
    const auto started = server.start();
    if (!started.ok()) return fail(started.error().toString());
    reportStart(settings, server.deviceName());
    if (settings.render.crashes != nullptr) {
        settings.render.crashes->ready();
        endWithoutMemory(*settings.render.crashes);
    }
    if (!again) {
        fmt::print("ready {} {}\n", settings.connectionFile.string(), server.deviceName());
        std::fflush(stdout);
    }
    runOrDie(server);
    server.withdraw();
    log::finish();
    watchdog.start();
    return 0;
}

/// A server that starts again has the token that its clients know.
int serveSupervised(ServerSettings settings, const DeviceFactory& device) {
    CrashRecord crashes;
    settings.token = makeToken();
    settings.followerToken = makeToken();
    settings.render.crashes = &crashes;
#ifdef __SANITIZE_THREAD__
    // The library log4cplus, which OpenVDB loads, has threads before main begins. ThreadSanitizer lets no
    // child of such a process make threads, so there is no supervisor.
    const int code = serve(settings, device, false);
#else
    const int code = supervise(crashes, [&](bool again) { return serve(settings, device, again); });
#endif
    removeConnectionFiles(settings, settings.token, settings.followerToken);
    return code;
}

/// Serves clients to the end; returns the exit code.
using Serve = std::function<int(const ServerSettings& settings, DeviceFactory device)>;

/// The same on all ranks, as their command lines are. Errors: of the options.
Result<std::unique_ptr<render::RankSteps>> stepsOf(const ServerSettings& settings) {
    MOTE_ASSIGN_OR_RETURN(auto roots, storage::Roots::parse(settings.roots));
    const auto memory = dataMemory(settings.memory);
    if (!memory.ok()) return memory.error().within("--memory");
    return sharedFileSteps(std::move(roots), *memory);
}

/// What keeps any rank from its work keeps all from theirs.
bool allReady(render::Ranks& ranks, const ServerSettings& settings,
              const Result<std::unique_ptr<render::RankSteps>>& steps) {
    std::optional<Error> error;
    if (!steps.ok()) error = steps.error();
    if (settings.device == render::DeviceKind::egl) {
        error = Error{ErrorCode::unsupported, "--device", "several ranks draw with cpu alone"};
    }
    if (error) log::error("rank {}: {}", ranks.rank(), error->toString());
    return ranks.greatest(error ? 1 : 0) == 0;
}

/// However the first rank ends: the others wait for its word.
class Dismissal {
  public:
    explicit Dismissal(render::Ranks& ranks) : ranks_(ranks) {}
    ~Dismissal() { render::dismissRanks(ranks_); }
    Dismissal(const Dismissal&) = delete;
    Dismissal& operator=(const Dismissal&) = delete;

  private:
    render::Ranks& ranks_;
};

/// What mote-server does as one of several ranks: the first serves the clients, the others draw for it.
/// Returns the exit code. Throws what `serve` throws.
int runRank(render::Ranks& ranks, const ServerSettings& settings, const Serve& serve) {
    auto steps = stepsOf(settings);
    if (!allReady(ranks, settings, steps)) return failed;
    if (ranks.rank() != 0) {
        // They end when the first rank does, which a launcher's signal reaches too.
        for (const int number : {SIGTERM, SIGINT, SIGHUP}) std::signal(number, SIG_IGN);
        render::serveRanks(ranks, **steps, settings.threads);
        return 0;
    }
    const Dismissal atLast(ranks);
    return serve(settings,
                 [&] { return std::make_unique<render::RankedDevice>(ranks, **steps, settings.threads); });
}

}  // namespace

int serverProgram(int argc, const char* const* argv, const DeviceMaker& maker) {
    auto options = parseOptions(argc, argv);
    if (const int* code = std::get_if<int>(&options)) return *code;
    auto settings = std::get<ServerSettings>(std::move(options));
    settings.prep = programBeside("mote-prep");
    settings.frames = programBeside("mote-frames");
    settings.stopOnSignals = true;
    const auto log = setUpLog(settings);
    if (!log.ok()) return fail(log.error().toString());
    // Errors of the write, both.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    storage::catchMappingFaults();
    const DeviceFactory device = [maker, kind = settings.device, threads = settings.threads] {
        return maker(kind, threads);
    };
    try {
        // What a launcher started ends with the launcher.
        if (const auto ranks = render::joinRanks()) {
            return runRank(*ranks, settings,
                           [](const auto& own, auto ranked) { return serve(own, std::move(ranked), false); });
        }
        return serveSupervised(std::move(settings), device);
    } catch (const std::exception& failure) {
        return fail(failure.what());
    }
}

}  // namespace mote::server
