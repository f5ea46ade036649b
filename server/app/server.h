// SPDX-License-Identifier: GPL-3.0-or-later
//
// Server: accepts clients on a Unix socket and lets their sessions share one device, one catalogue and one
// job queue. The thread that calls run() is its I/O thread; rendering, encoding and looking at the disk have
// threads of their own.
#pragma once

#include <filesystem>
#include <memory>

#include "protocol/scene/error.h"
#include "server/app/server_settings.h"

namespace mote::server {

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

}  // namespace mote::server
