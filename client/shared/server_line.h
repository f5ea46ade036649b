// SPDX-License-Identifier: GPL-3.0-or-later
//
// ServerLine: a server that a program works with, a running one or a private one, and the line to it. Main
// thread.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/shared/connection.h"
#include "client/shared/interrupt.h"
#include "client/shared/private_server.h"
#include "client/shared/wakeup.h"

namespace mote::client {

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

    /// Until it holds. Errors: cancelled (interrupted), why the line was lost.
    Status waitUntil(const std::function<bool()>& done);
    /// Until the server has welcomed us. Errors: as waitUntil.
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
