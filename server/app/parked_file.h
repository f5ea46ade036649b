// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParkedFile: keeps what outlives connections in a file of the state directory, so that it outlives the
// server. A change is written a moment later, with those that came meanwhile, on a thread of its own. Owned
// by the server, on its thread.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "server/session/parked_sessions.h"

namespace mote::server {

class ParkedFile {
  public:
    /// Reads what an earlier server has left, as far as it can be read; call once the state directory's lock
    /// is held. `sessions` outlive it.
    ParkedFile(asio::io_context& io, const std::filesystem::path& stateDirectory,
               std::chrono::milliseconds pause, ParkedSessions& sessions);
    /// Writes what was not written yet, and waits for it.
    ~ParkedFile();
    ParkedFile(const ParkedFile&) = delete;
    ParkedFile& operator=(const ParkedFile&) = delete;

    /// The sessions are not the same as before.
    void changed();

  private:
    void read();
    void hand();
    void write();

    const std::filesystem::path file_;
    const std::chrono::milliseconds pause_;
    ParkedSessions& sessions_;
    asio::steady_timer timer_;
    bool due_ = false;  // changes that were not handed to the thread

    std::mutex mutex_;
    std::condition_variable wake_;
    std::optional<std::string> text_;  // to be written
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace mote::server
