// SPDX-License-Identifier: GPL-3.0-or-later
//
// Server: accepts clients on a Unix socket, and a TCP port where one is asked for, and lets their sessions
// share one device, one catalogue and one job queue. The thread that calls run() is its I/O thread;
// rendering, encoding and looking at the disk have threads of their own.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/wire/address.h"
#include "server/frames/render_service.h"
#include "server/render/device.h"
#include "server/session/failure_delay.h"
#include "server/session/parked_sessions.h"
#include "server/session/startup_limits.h"

namespace mote::server {

/// ServerSettings: what a server is started with. A value.
struct ServerSettings {
    std::vector<std::string> roots;        ///< "NAME=DIR"
    std::filesystem::path stateDirectory;  ///< jobs and the socket; made where absent
    std::filesystem::path connectionFile;  ///< written when the server accepts, removed when it ends
    std::filesystem::path followerFile;    ///< the same for those who only follow; empty: there are none
    std::filesystem::path prep;            ///< the program mote-prep, for jobs
    std::filesystem::path frames;          ///< the program mote-frames, for films
    std::optional<wire::Address> tcp;      ///< where it listens beside its Unix socket, with TLS
    render::DeviceKind device = render::DeviceKind::automatic;
    std::string token;          ///< what clients must know; empty: a fresh one
    std::string followerToken;  ///< the same of those who only follow
    std::uint64_t memory = 0;   ///< bytes that the server may use, and a job besides; 0: no limit
    unsigned threads = 0;       ///< of a job, and of the cpu device; 0: their own choice

    std::string runner = "local";      ///< of jobs that make datasets and exports: or "mpi", "slurm"
    unsigned jobRanks = 1;             ///< processes of a job whose kind can have several, of mpi and slurm
    unsigned jobs = 1;                 ///< that run at once, and a film besides
    unsigned jobsWaiting = 1000;       ///< at most
    unsigned jobsKept = 1000;          ///< of those that have ended
    unsigned jobTime = 0;              ///< s, of a run of a job or film; 0: no limit
    bool allowUnconfinedJobs = false;  ///< they run even where the kernel cannot confine them

    std::filesystem::path logFile;     ///< empty: stderr
    std::string logFormat = "text";    ///< or "json"
    std::uint64_t logSize = 16 << 20;  ///< bytes of a file
    unsigned logFiles = 4;             ///< older ones that are kept
    std::string metrics;  ///< where HTTP is answered: "unix:PATH", "127.0.0.1:PORT"; empty: nowhere

    bool stopOnSignals = false;  ///< SIGTERM, SIGINT and SIGHUP end run()
    RenderSettings render;
    std::size_t maxSessions = 64;
    ParkingLimits parking;                         ///< of what outlives a session's connection
    std::chrono::milliseconds parkingPause{1000};  ///< from a change of that to its being written
    StartupLimits startups;                        ///< of connections that have shown no token yet
    StartupRandom random = uniformRandom();        ///< which of them go where there are too many
    FailureDelay failureDelay;                     ///< of the answer to a wrong token
    std::chrono::milliseconds handshakeTimeout{5000};
    std::chrono::milliseconds silence{30'000};            ///< of a client's, that ends its session; 0: none
    std::chrono::milliseconds idle{12 * 3600 * 1000};     ///< without a wish, that ends a session; 0: none
    std::chrono::milliseconds staleAfter{250};            ///< a frame in motion that waited so long is old
    std::chrono::milliseconds rescanInterval{2000};       ///< while clients are connected
    std::chrono::milliseconds deviceFailureTold{60'000};  ///< by /healthz, unless a picture is drawn before
};

class Server {
  public:
    /// Nothing is touched before start(). The factory makes the device on the thread that renders.
    Server(ServerSettings settings, DeviceFactory device);
    /// Not while run() runs. Withdraws, and waits for the picture under way.
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// Begins to accept; the connection file is written last. Errors: whatever keeps a server from its work,
    /// each naming the option, file or device; alreadyExists where a live server has the state directory or
    /// the connection file.
    Status start();

    /// Serves until stop(), then says farewell to every client and returns.
    void run();

    /// Any thread.
    void stop();

    /// Removes the socket, and the connection file if it is still ours. After run(): a client finds nobody.
    void withdraw();

    /// The device's name, after start().
    std::string deviceName() const;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Removes a server's connection files, of clients, of films and of followers, if they hold its tokens, which
/// are not empty then.
void removeConnectionFiles(const ServerSettings& settings, const std::string& token,
                           const std::string& followerToken);

}  // namespace mote::server
