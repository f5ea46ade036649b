// SPDX-License-Identifier: GPL-3.0-or-later
//
// Gateway: what mote-web does. It listens where browsers or a proxy come from, gives them the page, and pipes
// each WebSocket to a connection of its own to mote-server: a binary message is a frame of the protocol,
// header and all, both ways (docs/WEB.md). Nothing is kept but a part of the message under way, so that who
// does not read is not read from, up to the server. Owned by main(); everything happens on the thread of
// run().
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/web/gateway/access.h"
#include "protocol/base/error.h"
#include "protocol/wire/address.h"

namespace mote::web {

/// A file of the page, as it is sent.
struct PageFile {
    std::string type;                 ///< media type
    std::string plain, gzip, brotli;  ///< empty where there is no such file
    std::string tag;                  ///< of its contents, in quotation marks
};
using PageFiles = std::map<std::string, PageFile, std::less<>>;

/// The files of a folder, by name. Errors: notFound (no folder, or no index.html in it), the disk's.
Result<PageFiles> loadPage(const std::filesystem::path& folder);

/// PEM files of a certificate, with those that vouch for it, and its key.
struct CertificateFiles {
    std::filesystem::path certificate, key;
};

struct GatewaySettings {
    std::filesystem::path connectionFile;  ///< of mote-server, read anew for each browser
    wire::Address listen;                  ///< TCP of port 0: any
    std::optional<CertificateFiles> tls;   ///< browsers speak to us by https
    AccessSettings access;
    PageFiles page;
    std::size_t mostWaiting = 256;  ///< connections that have not shown a cookie; the oldest go first
    std::size_t mostKnown = 512;    ///< that have
    std::chrono::milliseconds requestTime{10'000};  ///< for a request's head, and for an answer to be taken
    std::chrono::milliseconds silence{60'000};      ///< of a WebSocket's other end
};

class Gateway {
  public:
    explicit Gateway(GatewaySettings settings);
    ~Gateway();
    Gateway(const Gateway&) = delete;
    Gateway& operator=(const Gateway&) = delete;

    /// Errors: invalidArgument, alreadyExists or internal ("--listen") where nobody can listen there;
    /// corrupt where a certificate or its key cannot be used, with the file's name.
    Status listen();
    /// Where a browser begins: the URL with a token in it.
    std::string link(Role role);
    /// Where it listens: HOST:PORT, or the path of a socket.
    std::string place() const;
    /// Serves until one of the descriptors becomes readable; then ends in a second or so.
    void run(std::span<const int> descriptors);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::web
