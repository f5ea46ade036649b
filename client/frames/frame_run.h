// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameRun: the views of a script, one after the other, from a server to files. Exact pictures only; while
// one is encoded here, the server draws the next. Main thread.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "client/frames/frame_report.h"
#include "client/frames/interrupt.h"
#include "client/frames/options.h"
#include "client/shared/connection.h"

namespace mote::client {

class FrameRun {
  public:
    /// Keeps references: they outlive it.
    FrameRun(const FramesOptions& options, const std::vector<proto::View>& views, Connection& connection,
             const Interrupt& interrupt);

    /// Waits for the server, checks the datasets, draws. Finished pictures stay whatever happens. Errors: the
    /// server's, the disk's, cancelled (interrupted).
    Status run();

  private:
    using Time = std::chrono::steady_clock::time_point;
    struct Asked {
        std::size_t index = 0;  // of the view
        std::uint64_t id = 0;   // the connection's, of the view
        Time since;
    };

    Status waitUntil(const std::function<bool()>& done);
    template <class T>
    Result<T> answer(const std::function<void(Connection::Reply<T>)>& ask);
    Status learnDatasets();
    std::string keyOf(const proto::View& view) const;
    std::vector<std::size_t> missing() const;
    std::filesystem::path fileOf(std::size_t index) const;

    bool isDocument() const { return options_.page.format() != proto::Page::FORMAT_UNSPECIFIED; }

    Status drawAll(const std::vector<std::size_t>& indices);
    Asked ask(std::size_t index);
    Result<ReceivedFrame> receive(const Asked& asked);
    Status finish(const Asked& asked, const ReceivedFrame& frame);
    Status report(const Asked& asked, const ReceivedFrame& frame) const;

    const FramesOptions& options_;
    const std::vector<proto::View>& views_;
    Connection& connection_;
    const Interrupt& interrupt_;
    std::map<std::string, std::string> manifests_;  // of the datasets shown, as JSON
    std::map<std::uint64_t, Error> failures_;       // by view id
};

}  // namespace mote::client
