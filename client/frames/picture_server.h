// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureServer: a server that draws frames for us. It is asked for several views ahead, so that it draws
// while earlier frames travel and are written. Main thread.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "client/shared/server_line.h"

namespace mote::client {

/// What came of a view that was asked for.
struct Answer {
    std::uint64_t view = 0;  ///< as ask() said
    Result<ReceivedFrame> frame;
};

class PictureServer {
  public:
    /// Starts it, or begins to connect. A server that sends nothing of what it was asked for as long as
    /// `patience` counts as lost, though it answers all else; 0: it is waited for. Errors: PrivateServer's.
    static Result<std::unique_ptr<PictureServer>> open(const ServerChoice& choice,
                                                       std::chrono::milliseconds patience, Wakeup& wakeup,
                                                       const Interrupt& interrupt);

    Connection& line() { return server_->line(); }
    /// Asks for the exact picture of a view, after those before it. Returns its number.
    std::uint64_t ask(const proto::View& view, proto::PixelFormat format,
                      const std::optional<proto::Page>& page);
    /// Views that were asked for and not answered.
    std::size_t open() const { return asked_.size(); }
    /// Lets the line's callbacks run; what was answered since.
    std::vector<Answer> poll();

    /// As of ServerLine.
    Status waitUntilConnected() { return server_->waitUntilConnected(); }
    template <class T>
    Result<T> answerTo(const std::function<void(Connection::Reply<T>)>& ask) {
        return server_->answerTo<T>(ask);
    }
    std::optional<Error> lost() const { return server_->lost(); }
    /// How often the line was opened again: the server has forgotten what it drew before.
    unsigned returns() const { return returns_; }

  private:
    struct Asked {
        std::uint32_t width = 0, height = 0;  ///< pixels; 0 of a document
    };

    PictureServer(std::unique_ptr<ServerLine> server, std::chrono::milliseconds patience)
        : server_(std::move(server)), patience_(patience) {}
    void listen();
    Answer toAnswer(std::uint64_t view, ReceivedFrame frame);
    void watchProgress(bool answered);
    Result<ReceivedFrame> checked(const Asked& asked, ReceivedFrame frame) const;

    std::unique_ptr<ServerLine> server_;
    const std::chrono::milliseconds patience_;
    std::chrono::steady_clock::time_point progressAt_;
    std::uint64_t pictureBytes_ = 0;
    std::map<std::uint64_t, Asked> asked_;
    std::vector<Answer> failures_;
    bool connected_ = false;
    unsigned returns_ = 0;
};

}  // namespace mote::client
