// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-server: options, one server or one of its ranks, its exit code.
#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <pthread.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <semaphore>
#include <thread>

#include "server/render/ranks/mpi_ranks.h"
#include "server/session/options.h"
#include "server/session/rank_program.h"
#include "server/session/server.h"
#include "storage/mapping_guard.h"

namespace {

using namespace std::chrono_literals;

constexpr int failed = 1;
// The promise is 10 s from the signal; a driver that hangs must not break it.
constexpr auto endTimeout = 8s;

std::filesystem::path programBeside(const char* name) {
    std::error_code code;
    return std::filesystem::read_symlink("/proc/self/exe", code).parent_path() / name;
}

void setUpLog() {
    spdlog::set_default_logger(spdlog::stderr_color_mt("mote-server"));
    spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
    // What a client sends must not fill the log; it becomes an Error that we report.
    google::protobuf::SetLogHandler(nullptr);
}

/// Ends the process where `finished` is not released in time.
class Watchdog {
  public:
    void start() {
        thread_ = std::thread([this] {
            if (finished_.try_acquire_for(endTimeout)) return;
            spdlog::error("the device does not end; leaving it behind");
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

/// Until a signal ends it. Returns the exit code.
int serve(const mote::server::ServerSettings& settings, mote::server::DeviceFactory device) {
    Watchdog watchdog;
    mote::server::Server server(settings, std::move(device));
    const auto started = server.start();
    if (!started.ok()) {
        fmt::print(stderr, "mote-server: {}\n", started.error().toString());
        return failed;
    }
    fmt::print("ready {} {}\n", settings.connectionFile.string(), server.deviceName());
    std::fflush(stdout);
    server.run();
    server.withdraw();
    watchdog.start();
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    auto options = mote::server::parseOptions(argc, argv);
    if (const int* code = std::get_if<int>(&options)) return *code;
    auto settings = std::get<mote::server::ServerSettings>(std::move(options));
    settings.prep = programBeside("mote-prep");
    settings.stopOnSignals = true;
    setUpLog();
    std::signal(SIGPIPE, SIG_IGN);
    mote::storage::catchMappingFaults();
    const auto makeDevice = [kind = settings.device, threads = settings.threads] {
        return mote::render::createDevice(kind, threads);
    };
    try {
        const auto ranks = mote::render::joinRanks();
        return ranks ? mote::server::runRank(*ranks, settings, serve) : serve(settings, makeDevice);
    } catch (const std::exception& failure) {
        fmt::print(stderr, "mote-server: {}\n", failure.what());
        return failed;
    }
}
