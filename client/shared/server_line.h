// SPDX-License-Identifier: GPL-3.0-or-later
//
// ServerLine: a server that a program works with, a running one or a private one, and the line to it. Main
// thread.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/connection.h"
#include "client/shared/interrupt.h"
#include "protocol/base/error.h"

namespace mote::client {

/// TemporaryFolder: a fresh folder that only this user may enter, removed with all it holds when the object
/// goes. Not copied; any thread.
class TemporaryFolder {
  public:
    /// Throws std::system_error.
    explicit TemporaryFolder(std::string_view prefix);
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

struct ServerCommand {
    std::filesystem::path program;
    std::vector<std::string> roots;     ///< "NAME=DIR"
    std::optional<std::string> device;  ///< the server's own choice where absent
    unsigned threads = 0;               ///< likewise where 0
};

/// A mote-server of our own, in a temporary folder, for as long as the object lives. It stands
/// in a process group of its own (a Ctrl-C at the terminal is for us alone), and is told to end where we are
/// killed. Main thread.
class PrivateServer {
  public:
    /// Starts one and waits until it is ready. Its folder's name begins with `owner`; what owners of this
    /// name left when they were killed, a day ago or earlier, is removed first. Errors: notFound (no
    /// program), internal with what the server said, cancelled (interrupted).
    static Result<std::unique_ptr<PrivateServer>> start(std::string_view owner, const ServerCommand& command,
                                                        const Interrupt& interrupt);
    /// The same in two parts, between which it starts by itself.
    static Result<std::unique_ptr<PrivateServer>> launch(std::string_view owner, const ServerCommand& command,
                                                         const Interrupt& interrupt);
    Status waitUntilReady(const Interrupt& interrupt);
    /// SIGTERM, after 15 s SIGKILL; then its folder is removed.
    ~PrivateServer();
    PrivateServer(const PrivateServer&) = delete;
    PrivateServer& operator=(const PrivateServer&) = delete;

    std::filesystem::path connectionFile() const { return folder_.path() / "connection.json"; }
    /// The end of what it said on stderr, one line; empty if it said nothing.
    std::string lastWords() const;
    /// Becomes readable when it ends, for poll().
    int process() const { return process_; }

  private:
    explicit PrivateServer(std::string_view owner) : folder_(owner) {}
    Status execute(const ServerCommand& command, const Interrupt& interrupt);
    std::filesystem::path logFile() const { return folder_.path() / "log"; }
    Error died() const;

    TemporaryFolder folder_;
    pid_t child_ = -1;
    int process_ = -1;  // pidfd
    int output_ = -1;   // its stdout, our end
    int log_ = -1;      // locked
};

/// The server's program beside our own.
std::filesystem::path serverBesideUs();

/// Signals are looked for this often.
inline constexpr std::chrono::milliseconds signalPatience{50};

/// Either a connection file or a private server's command.
struct ServerChoice {
    std::optional<std::filesystem::path> connect;
    ServerCommand spawn = {};
    bool background = false;  ///< it draws for us only while nobody else waits
    /// A server that ended is waited for as long as there is such a file; empty: for a moment.
    std::filesystem::path waitsWhile = {};
};

class ServerLine {
  public:
    /// Starts it, or begins to connect. `program` is ours, "mote-frames". Errors: PrivateServer's.
    static Result<std::unique_ptr<ServerLine>> open(const std::string& program, const ServerChoice& choice,
                                                    Wakeup& wakeup, const Interrupt& interrupt);

    Connection& line() { return *line_; }

    /// Waits until it holds. Errors: cancelled (interrupted), why the line was lost.
    Status waitUntil(const std::function<bool()>& done);
    /// Waits until the server has welcomed us. Errors: as waitUntil.
    Status waitUntilConnected();
    /// Asks a question, and waits for its answer.
    template <class T>
    Result<T> answerTo(const std::function<void(Connection::Reply<T>)>& ask) {
        const auto got = std::make_shared<std::optional<Result<T>>>();
        ask([got](Result<T> result) { *got = std::move(result); });
        MOTE_RETURN_IF_ERROR(waitUntil([&] { return got->has_value(); }));
        return **got;
    }

    /// Gives the server a moment to hear what was said last, before the line is closed: also after a signal.
    void farewell();

    /// The line counts as lost from now on.
    void giveUp(Error reason) { givenUp_ = std::move(reason); }
    /// Why the line is lost, and what a private server last said; nothing while it is not.
    std::optional<Error> lost() const;

  private:
    ServerLine(const Interrupt& interrupt, Wakeup& wakeup) : interrupt_(interrupt), wakeup_(wakeup) {}

    const Interrupt& interrupt_;
    Wakeup& wakeup_;
    std::unique_ptr<PrivateServer> server_;
    std::unique_ptr<Connection> line_;
    std::optional<Error> givenUp_;
    std::filesystem::path waitsWhile_;
};

}  // namespace mote::client
