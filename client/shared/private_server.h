// SPDX-License-Identifier: GPL-3.0-or-later
//
// PrivateServer: a mote-server of our own, in a temporary folder, for as long as the object lives. It stands
// in a process group of its own (a Ctrl-C at the terminal is for us alone), and is told to end where we are
// killed. Main thread.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/interrupt.h"
#include "protocol/scene/error.h"

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

class PrivateServer {
  public:
    /// Starts one and waits until it is ready; its folder's name begins with `owner`. Errors: notFound (no
    /// program), internal with what the server said, cancelled (interrupted).
    static Result<std::unique_ptr<PrivateServer>> start(std::string_view owner, const ServerCommand& command,
                                                        const Interrupt& interrupt);
    /// SIGTERM, after 15 s SIGKILL; then its folder is removed.
    ~PrivateServer();
    PrivateServer(const PrivateServer&) = delete;
    PrivateServer& operator=(const PrivateServer&) = delete;

    std::filesystem::path connectionFile() const { return folder_.path() / "connection.json"; }
    /// The end of what it said on stderr, one line; empty where it said nothing.
    std::string lastWords() const;

  private:
    explicit PrivateServer(std::string_view owner) : folder_(owner) {}
    Status launch(const ServerCommand& command, const Interrupt& interrupt);
    Status waitUntilReady(const Interrupt& interrupt);
    std::filesystem::path logFile() const { return folder_.path() / "log"; }
    Error died() const;

    TemporaryFolder folder_;
    pid_t child_ = -1;
    int process_ = -1;  // pidfd
    int output_ = -1;   // its stdout, our end
};

/// The server's program beside our own.
std::filesystem::path serverBesideUs();

}  // namespace mote::client
