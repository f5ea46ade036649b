// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureServer: a server that draws frames for us, a running one or a private one, and the line to it. It is
// asked for several views ahead, so that it draws while earlier frames travel and are written. Main thread.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/frames/interrupt.h"
#include "client/frames/private_server.h"
#include "client/frames/wakeup.h"
#include "client/shared/connection.h"

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

/// What came of a view that was asked for.
struct Answer {
    std::uint64_t view = 0;  ///< as ask() said
    Result<ReceivedFrame> frame;
};

class PictureServer {
  public:
    /// Starts it, or begins to connect. Errors: PrivateServer's.
    static Result<std::unique_ptr<PictureServer>> open(const ServerChoice& choice, Wakeup& wakeup,
                                                       const Interrupt& interrupt);

    Connection& line() { return *line_; }
    /// Asks for the exact picture of a view, after those before it. Returns its number.
    std::uint64_t ask(const proto::View& view, proto::PixelFormat format,
                      const std::optional<proto::Page>& page);
    /// Views that were asked for and not answered.
    std::size_t open() const { return asked_.size(); }
    /// Lets the line's callbacks run; what was answered since.
    std::vector<Answer> poll();

    /// Until it holds. Errors: cancelled (interrupted), why the line was lost.
    Status waitUntil(const std::function<bool()>& done);
    /// Asks a question, and waits for its answer.
    template <class T>
    Result<T> answerTo(const std::function<void(Connection::Reply<T>)>& ask) {
        const auto got = std::make_shared<std::optional<Result<T>>>();
        ask([got](Result<T> result) { *got = std::move(result); });
        MOTE_RETURN_IF_ERROR(waitUntil([&] { return got->has_value(); }));
        return **got;
    }

    /// Why the line is lost, and what a private server last said; nothing while it is not.
    std::optional<Error> lost() const;
    /// How often the line was opened again: the server has forgotten what it drew before.
    unsigned returns() const { return returns_; }

  private:
    struct Asked {
        std::uint32_t width = 0, height = 0;  ///< pixels; 0 of a document
    };

    PictureServer(const Interrupt& interrupt, Wakeup& wakeup) : interrupt_(interrupt), wakeup_(wakeup) {}
    void listen();
    Result<ReceivedFrame> checked(const Asked& asked, ReceivedFrame frame) const;

    const Interrupt& interrupt_;
    Wakeup& wakeup_;
    std::unique_ptr<PrivateServer> server_;
    std::unique_ptr<Connection> line_;
    std::map<std::uint64_t, Asked> asked_;
    std::vector<Answer> failures_;
    std::optional<Error> complaint_;  // of the server, about no view that we know
    bool connected_ = false;
    unsigned returns_ = 0;
    std::filesystem::path waitsWhile_;
};

}  // namespace mote::client
