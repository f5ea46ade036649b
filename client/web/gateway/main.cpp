// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client/shared/interrupt.h"
#include "client/shared/server_line.h"
#include "client/web/gateway/gateway.h"
#include "protocol/base/error.h"
#include "protocol/cli/command.h"
#include "protocol/wire/connection_file.h"

namespace mote::web {
namespace {

namespace fs = std::filesystem;

constexpr const char* footer = R"(
It serves a page that shows what mote-server draws, and carries the page's WebSocket to the server. It prints one line,
"ready URL", when it listens. The URL holds a token that is good once; the browser that opens it gets a cookie. Then a
line "link URL" gives the next one. SIGTERM ends it.

Examples:
  mote-web --spawn data=/scratch/plots
  mote-web --connect ~/.mote/connection.json --listen 127.0.0.1:8000
  mote-web --connect c.json --listen unix:$HOME/.mote/web.sock --base-url /node/n12/8000/ --origin https://hub.example.org

docs/WEB.md describes proxies, notebooks and what is checked.

Exit status: 0 after SIGTERM, 2 for wrong usage, 128 + N after another signal N, else 1.)";

struct WebOptions {
    std::optional<fs::path> connect;
    client::ServerCommand spawn{client::serverBesideUs(), {}, {}, 0};
    fs::path page;
    wire::Address listen;
    std::optional<CertificateFiles> tls;
    AccessSettings access;
};

/// What the command line says before it is checked.
struct RawOptions {
    WebOptions options;
    std::string connect, device, listen = "127.0.0.1:0", certificate, key;
};

void declare(const cli::Command& app, RawOptions& raw) {
    app.footer(footer);
    auto& options = raw.options;
    const auto server = app.group("server", "Which server is shown (exactly one of these)");
    server.option("--connect", raw.connect, "Connection file of a running server").valueName("FILE");
    server.option("--spawn", options.spawn.roots, "Start a private server with this root; repeatable")
        .repeatable()
        .valueName("NAME=DIR");
    server.requireOneOption();
    app.option("--device", raw.device, "Device of the private server: auto, cpu or egl").valueName("NAME");
    app.option("--threads", options.spawn.threads, "Threads of the private server; 0: all cores");
    app.option("--listen", raw.listen,
               "Where browsers or a proxy connect: HOST:PORT (port 0: any), or unix:PATH")
        .showDefault()
        .valueName("PLACE");
    app.option("--tls-certificate", raw.certificate,
               "PEM file of a certificate and its chain; browsers then use https")
        .valueName("FILE");
    app.option("--tls-key", raw.key, "PEM file of its key; default: the certificate's file")
        .valueName("FILE");
    app.option("--base-url", options.access.basePath, "Path under which a proxy shows it, from / to /")
        .showDefault()
        .valueName("PATH");
    app.option("--origin", options.access.origins,
               "The proxy's address as browsers see it, https://HOST; repeatable")
        .repeatable()
        .valueName("URL");
    app.flag("--any-host", options.access.anyHost,
             "Accepts any host name: for a proxy whose address is not known");
    app.option("--frame-ancestor", options.access.frameAncestors,
               "Whose pages may frame it, besides its own, http://HOST:PORT; repeatable")
        .repeatable()
        .valueName("URL");
    app.flag("--read-only", options.access.readOnly, "Only for looking: no jobs, no films");
    app.flag(
        "--no-token", options.access.trusting,
        "With --listen unix: no token, since the proxy authenticates; whoever reaches the socket comes in");
    app.option("--page", options.page, "The folder of the page").hidden();
}

Status checkAccess(AccessSettings& access, const wire::Address& listen) {
    auto& base = access.basePath;
    if (!base.starts_with('/') || base.find_first_of("?#\r\n ;") != std::string::npos || base.size() > 1024)
        return invalid("--base-url", fmt::format("\"{}\" is no path from / on", base));
    if (!base.ends_with('/')) base += '/';
    for (auto& origin : access.origins) {
        if (origin.ends_with('/')) origin.pop_back();
        if (!isOrigin(origin) || origin.ends_with('*'))
            return invalid("--origin", fmt::format("\"{}\" is not https://HOST or http://HOST:PORT", origin));
    }
    for (const auto& each : access.frameAncestors) {
        if (!isOrigin(each))
            return invalid("--frame-ancestor",
                           fmt::format("\"{}\" is not https://HOST or http://HOST:PORT", each));
    }
    const bool local = listen.kind == wire::Address::Kind::unixSocket;
    if (access.trusting && !local)
        return invalid("--no-token",
                       "anybody of this machine reaches a port: it goes with --listen unix:PATH alone");
    if (local && access.origins.empty()) access.anyHost = true;
    return success();
}

Status check(RawOptions& raw) {
    for (const auto& root : raw.options.spawn.roots) {
        const auto equals = root.find('=');
        if (equals == 0 || equals == std::string::npos || equals + 1 == root.size())
            return invalid("--spawn", fmt::format("\"{}\" is not NAME=DIR", root));
    }
    if (!raw.connect.empty()) raw.options.connect = raw.connect;
    if (!raw.device.empty()) raw.options.spawn.device = raw.device;
    const bool local = raw.listen.starts_with("unix:");
    const auto address = wire::parseAddress(local ? raw.listen : "tcp:" + raw.listen);
    if (!address.ok()) return invalid("--listen", address.error().message);
    raw.options.listen = *address;
    if (raw.certificate.empty() && !raw.key.empty())
        return invalid("--tls-key", "goes with --tls-certificate FILE");
    if (!raw.certificate.empty() && local)
        return invalid("--tls-certificate", "goes with a port: the proxy before a Unix socket has one");
    if (!raw.certificate.empty())
        raw.options.tls = {raw.certificate, raw.key.empty() ? raw.certificate : raw.key};
    raw.options.access.encrypted = raw.options.tls.has_value();
    return checkAccess(raw.options.access, raw.options.listen);
}

std::variant<WebOptions, int> parseWebOptions(int argc, const char* const* argv) {
    RawOptions raw;
    const cli::Program program("mote-web shows datasets in any browser.", "mote-web");
    declare(program.command(), raw);
    if (const auto end = program.parse(argc, argv, [&] { return check(raw); })) return *end;
    return std::move(raw.options);
}

/// BIN/../share/mote/web, where it is built and where it is installed.
fs::path pageFolder(const WebOptions& options) {
    if (!options.page.empty()) return options.page;
    return options.spawn.program.parent_path().parent_path() / "share" / "mote" / "web";
}

/// Serves until a signal. Errors: the page's, the private server's, the connection file's, of --listen.
Status runWeb(const WebOptions& options, const client::Interrupt& interrupt) {
    GatewaySettings settings;
    MOTE_ASSIGN_OR_RETURN(settings.page, loadPage(pageFolder(options)));
    std::unique_ptr<client::PrivateServer> server;
    if (!options.connect) {
        MOTE_ASSIGN_OR_RETURN(server, client::PrivateServer::start("mote-web", options.spawn, interrupt));
    }
    settings.connectionFile = server ? server->connectionFile() : *options.connect;
    MOTE_RETURN_IF_ERROR(wire::readConnectionFile(settings.connectionFile));
    settings.listen = options.listen;
    settings.tls = options.tls;
    settings.access = options.access;
    Gateway gateway(std::move(settings));
    MOTE_RETURN_IF_ERROR(gateway.listen());
    fmt::print("ready {}\n", gateway.link(Role::owner));
    // A proxy's address does not say where we listen.
    if (!options.access.origins.empty()) fmt::print("listens at {}\n", gateway.place());
    std::fflush(stdout);
    std::vector<int> ends{interrupt.descriptor()};
    if (server) ends.push_back(server->process());
    gateway.run(ends);
    if (!interrupt.requested())
        return Error{ErrorCode::internal, "mote-server", "ended: " + server->lastWords()};
    if (interrupt.requested() && interrupt.signal() != SIGTERM) return wasCancelled("interrupted");
    return success();
}

}  // namespace
}  // namespace mote::web

int main(int argc, char** argv) {
    using namespace mote;
    return client::runProgram("mote-web", web::parseWebOptions, web::runWeb, argc, argv);
}
