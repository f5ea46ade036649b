// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/web/gateway/gateway.h"

#include <sys/stat.h>
#include <unistd.h>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <fmt/format.h>
#include <charconv>
#include <cstdio>
#include <deque>
#include <functional>
#include <list>
#include <optional>
#include <utility>
#include <variant>

#include "client/web/gateway/bridge.h"
#include "protocol/base/complain.h"

namespace mote::web {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;
using Acceptor = net::basic_socket_acceptor<net::generic::stream_protocol>;

/// What a connection keeps on its way to a browser that does not read, bytes, beside a piece of a message.
constexpr int mostUnsent = 256 << 10;
constexpr std::chrono::milliseconds acceptPause{50}, endPatience{1000}, endPause{20}, roomPatience{20'000};

using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;

/// The greatest head and body of a request, bytes.
constexpr std::uint32_t mostHead = 16U << 10;
constexpr std::uint64_t mostBody = 64U << 10;

/// A request that becomes a WebSocket of this role.
struct Upgrade {
    Role role = Role::nobody;
};

/// A request for the view of a room, once it is another than that of this number.
struct Await {
    std::string room;
    std::uint64_t after = 0;
};

struct Answered {
    std::variant<Response, Upgrade, Await> with;
    Role role = Role::nobody;  ///< that the request has shown
};

/// Views that notebooks and pages share, by names that cannot be guessed: the latest of each, as who wrote it
/// sent it. Of many those go that were begun first.
class Rooms {
  public:
    struct Room {
        std::uint64_t number = 0;  ///< grows with each view
        std::string view;
    };

    /// The number of the view in the room.
    std::uint64_t put(const std::string& name, std::string view) {
        if (!rooms_.contains(name)) {
            if (order_.size() == mostRooms) {
                rooms_.erase(order_.front());
                order_.pop_front();
            }
            order_.push_back(name);
        }
        auto& room = rooms_[name];
        room.view = std::move(view);
        return ++room.number;
    }
    /// Nothing where there is none.
    const Room* find(const std::string& name) const {
        const auto found = rooms_.find(name);
        return found == rooms_.end() ? nullptr : &found->second;
    }
    static bool isName(std::string_view name) {
        return name.size() >= 16 && name.size() <= 64 &&
               name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
    }

  private:
    static constexpr std::size_t mostRooms = 64;

    std::map<std::string, Room> rooms_;
    std::deque<std::string> order_;
};

std::string_view textOf(boost::beast::string_view text) {
    return {text.data(), text.size()};
}

std::string_view fieldOf(const Request& request, boost::beast::string_view name) {
    return textOf(request[name]);
}

/// Of "PATH?a=b&token=...": the path, and what is said behind it; empty where it is not.
struct Target {
    std::string_view path, token, after;
};

Target targetOf(const Request& request) {
    const auto target = textOf(request.target());
    const auto mark = target.find('?');
    Target found{target.substr(0, mark), {}, {}};
    auto rest = mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
    while (!rest.empty()) {
        const auto end = rest.find('&');
        const auto pair = rest.substr(0, end);
        if (pair.starts_with("token=")) found.token = pair.substr(6);
        if (pair.starts_with("after=")) found.after = pair.substr(6);
        rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    }
    return found;
}

/// Says how what we send may be used, whatever it is.
void guard(Response& response, const Access& access, std::string_view host) {
    response.set(http::field::server, "mote-web");
    response.set("Content-Security-Policy", access.policy(host));
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Permissions-Policy", "camera=(), geolocation=(), microphone=()");
    if (access.settings().frameAncestors.empty()) response.set("X-Frame-Options", "SAMEORIGIN");
}

Caller callerOf(const Request& request) {
    return {fieldOf(request, "Host"), fieldOf(request, "Origin"), fieldOf(request, "X-Forwarded-Host"),
            fieldOf(request, "Cookie")};
}

Response sentence(http::status status, std::string_view text, unsigned version, const Access& access) {
    Response response(status, version);
    guard(response, access, {});
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.set(http::field::cache_control, "no-store");
    response.body() = std::string(text) + "\n";
    return response;
}

bool accepts(const Request& request, std::string_view coding) {
    return http::token_list(request[http::field::accept_encoding]).exists({coding.data(), coding.size()});
}

Response fileResponse(const Request& request, const PageFile& file, const Access& access) {
    Response response(http::status::ok, request.version());
    guard(response, access, fieldOf(request, "Host"));
    response.set(http::field::content_type, file.type);
    response.set(http::field::etag, file.tag);
    response.set(http::field::cache_control, "private, no-cache");
    response.set(http::field::vary, "Accept-Encoding, Cookie");
    if (fieldOf(request, "If-None-Match") == file.tag) {
        response.result(http::status::not_modified);
        return response;
    }
    if (!file.brotli.empty() && accepts(request, "br")) {
        response.set(http::field::content_encoding, "br");
        response.body() = file.brotli;
    } else if (!file.gzip.empty() && accepts(request, "gzip")) {
        response.set(http::field::content_encoding, "gzip");
        response.body() = file.gzip;
    } else {
        response.body() = file.plain;
    }
    return response;
}

Response roomResponse(const Request& request, const Access& access, std::uint64_t number, std::string view) {
    Response response(http::status::ok, request.version());
    guard(response, access, fieldOf(request, "Host"));
    response.set(http::field::content_type, "application/octet-stream");
    response.set(http::field::cache_control, "no-store");
    response.set("X-Number", std::to_string(number));
    response.body() = std::move(view);
    return response;
}

/// A view is put into a room, or waited for.
Answered roomAnswer(const Request& request, const Access& access, Rooms& rooms, Role role,
                    std::string_view name, std::string_view after) {
    const auto refuse = [&](http::status status, std::string_view why) {
        return Answered{sentence(status, why, request.version(), access), role};
    };
    if (!Rooms::isName(name)) return refuse(http::status::not_found, "That is no name of a room.");
    Await wait;
    wait.room = name;
    std::from_chars(after.data(), after.data() + after.size(), wait.after);
    if (request.method() == http::verb::post) {
        if (role != Role::owner || !access.knowsOrigin(callerOf(request)))
            return refuse(http::status::forbidden, "Only its owner's page changes a view.");
        const auto* const room = rooms.find(wait.room);
        if (!after.empty() && (room == nullptr ? 0 : room->number) != wait.after)
            return refuse(http::status::conflict, "Another view was put there since.");
        const auto number = rooms.put(wait.room, request.body());
        return {roomResponse(request, access, number, {}), role};
    }
    return {std::move(wait), role};
}

/// A link for another browser, as JSON.
Response linkResponse(const Request& request, Access& access, Role role) {
    if (role != Role::owner || !access.knowsOrigin(callerOf(request)))
        return sentence(http::status::forbidden, "Only its owner's page gives links.", request.version(),
                        access);
    const auto wanted = request.body() == "owner" ? Role::owner : Role::follower;
    Response response(http::status::ok, request.version());
    guard(response, access, fieldOf(request, "Host"));
    response.set(http::field::content_type, "application/json");
    response.set(http::field::cache_control, "no-store");
    response.body() = "{\"token\":\"" + access.makeToken(wanted) + "\"}";
    return response;
}

Response refusal(const Request& request, std::string_view token, const Access& access) {
    const std::string_view why = token.empty() ? "This page opens by a link with a token: mote-web prints it."
                                               : "This link was used before, or is none: ask for another.";
    return sentence(http::status::forbidden, why, request.version(), access);
}

Answered upgradeOf(const Request& request, const Access& access, Role role) {
    if (!access.knowsOrigin(callerOf(request)))
        return {sentence(http::status::forbidden, "This page is not ours.", request.version(), access), role};
    return {Upgrade{role}, role};
}

/// What a request is answered with; `tokenUsed` is called where an owner's token was used up.
Answered answer(const Request& request, Access& access, Rooms& rooms, const PageFiles& page,
                const std::function<void()>& tokenUsed) {
    const auto version = request.version();
    const auto caller = callerOf(request);
    if (!access.knowsHost(caller.host))
        return {sentence(http::status::forbidden, "This is not the name of this server: see --origin.",
                         version, access)};
    const auto [path, token, after] = targetOf(request);
    auto role = access.roleOf(caller);
    const auto below = access.pathBelowBase(path);
    // Whoever has a cookie keeps what it gives; the token then stays good for somebody else.
    std::string cookie;
    const bool get = request.method() == http::verb::get;
    if (role == Role::nobody && get && below == "/" && !token.empty()) {
        role = access.useToken(token);
        if (role != Role::nobody)
            cookie = access.cookie(role, fieldOf(request, "X-Forwarded-Proto") == "https");
        if (role == Role::owner) tokenUsed();
        if (role == Role::owner && access.settings().readOnly) role = Role::follower;
    }
    if (role == Role::nobody) return {refusal(request, token, access)};
    if (!below) {
        auto moved = sentence(http::status::permanent_redirect, "It is a folder.", version, access);
        moved.set(http::field::location, access.settings().basePath);
        return {std::move(moved), role};
    }
    if (*below == "/link" && request.method() == http::verb::post)
        return {linkResponse(request, access, role), role};
    if (below->starts_with("/room/") && (get || request.method() == http::verb::post))
        return roomAnswer(request, access, rooms, role, below->substr(6), after);
    if (!get && request.method() != http::verb::head)
        return {sentence(http::status::method_not_allowed, "There is GET and HEAD.", version, access), role};
    if (*below == "/ws") {
        if (boost::beast::websocket::is_upgrade(request)) return upgradeOf(request, access, role);
        return {sentence(http::status::upgrade_required, "This is a WebSocket.", version, access), role};
    }
    const auto found = page.find(*below == "/" ? std::string_view("index.html") : below->substr(1));
    if (found == page.end())
        return {sentence(http::status::not_found, "There is no such file.", version, access), role};
    auto response = fileResponse(request, found->second, access);
    if (!cookie.empty()) response.set(http::field::set_cookie, cookie);
    if (*below == "/") response.set(http::field::cache_control, "no-store");
    return {std::move(response), role};
}

/// One browser's connection.
struct Visit {
    Visit(Acceptor::protocol_type::socket socket, net::ssl::context* tls) : stream(std::move(socket), tls) {}

    void close() { (socket ? socket->next_layer() : stream).plain().close(); }

    BrowserStream stream;
    std::optional<WebSocket> socket;  ///< once it is one: it has the stream then
    bool known = false;               ///< it has shown a cookie
    bool dropped = false;             ///< for another that came
};

using Visits = std::list<std::shared_ptr<Visit>>;

/// The address of a socket that listens, as a URL has it.
std::string hostOf(const net::ip::tcp::endpoint& endpoint) {
    const auto address = endpoint.address();
    return address.is_v6() ? fmt::format("[{}]:{}", address.to_string(), endpoint.port())
                           : fmt::format("{}:{}", address.to_string(), endpoint.port());
}

Error listenError(const std::string& where, const error_code& code) {
    return {ErrorCode::internal, "--listen",
            fmt::format("nobody can listen at {}: {}", where, code.message())};
}

}  // namespace

struct Gateway::Impl {
    explicit Impl(GatewaySettings given)
        : settings(std::move(given)), access(settings.access), acceptor(context), pause(context) {}

    Status listenUnix() {
        const auto& path = settings.listen.path;
        error_code code;
        // A socket that a dead one left is in the way; anything else stays.
        struct stat found {};
        if (::lstat(path.c_str(), &found) == 0 && S_ISSOCK(found.st_mode)) {
            net::local::stream_protocol::socket probe(context);
            probe.connect(net::local::stream_protocol::endpoint(path), code);
            if (!code)
                return Error{ErrorCode::alreadyExists, "--listen", path + " is somebody's who listens there"};
            ::unlink(path.c_str());
            code.clear();
        }
        const auto before = ::umask(0177);
        net::local::stream_protocol::acceptor local(context);
        local.open(net::local::stream_protocol(), code);
        if (!code) local.bind(net::local::stream_protocol::endpoint(path), code);
        ::umask(before);
        if (code) return listenError(path, code);
        return take(local.release(code), net::generic::stream_protocol(AF_UNIX, 0), path);
    }

    Status loadCertificate() {
        if (!settings.tls) return success();
        error_code code;
        tls.emplace(net::ssl::context::tlsv13_server);
        // Nobody is there to type one.
        tls->set_password_callback([](std::size_t, auto) { return std::string(); });
        tls->use_certificate_chain_file(settings.tls->certificate, code);
        if (code) return corrupt(settings.tls->certificate.string(), "is no certificate: " + code.message());
        tls->use_private_key_file(settings.tls->key, net::ssl::context::pem, code);
        if (code) return corrupt(settings.tls->key.string(), "is no key of it: " + code.message());
        return success();
    }

    Status listenTcp() {
        error_code code;
        const auto address = net::ip::make_address(settings.listen.host, code);
        if (code) return invalid("--listen", settings.listen.host + " is no number of a host");
        const net::ip::tcp::endpoint wanted(address, settings.listen.port);
        net::ip::tcp::acceptor tcp(context);
        tcp.open(wanted.protocol(), code);
        if (!code) tcp.set_option(net::ip::tcp::acceptor::reuse_address(true), code);
        if (!code) tcp.bind(wanted, code);
        if (code) return listenError(settings.listen.toString(), code);
        origin = hostOf(tcp.local_endpoint(code));
        auto own = settings.access;
        own.hosts.push_back(origin);
        access = Access(std::move(own));
        return take(tcp.release(code), net::generic::stream_protocol(wanted.protocol()), origin);
    }

    Status take(int descriptor, net::generic::stream_protocol protocol, const std::string& where) {
        error_code code;
        acceptor.assign(protocol, descriptor, code);
        if (!code) acceptor.listen(1024, code);
        if (code) return listenError(where, code);
        return success();
    }

    net::awaitable<void> acceptAll() {
        while (true) {
            error_code code;
            auto socket = co_await acceptor.async_accept(into(code));
            if (ending) co_return;
            if (code) {
                // No descriptor is left: those make room that have waited longest.
                dropOldestWaiting();
                pause.expires_after(acceptPause);
                co_await pause.async_wait(into(code));
                continue;
            }
            if (waiting >= settings.mostWaiting) dropOldestWaiting();
            ++waiting;
            const auto place = visits.insert(
                visits.end(), std::make_shared<Visit>(std::move(socket), tls ? &*tls : nullptr));
            net::co_spawn(
                context, [this, place] { return receive(place); },
                [this, place](const std::exception_ptr& failure) {
                    if (failure) tell(failure);
                    if ((*place)->known) {
                        --known;
                    } else {
                        --waiting;
                    }
                    visits.erase(place);
                });
        }
    }

    static void tell(const std::exception_ptr& failure) {
        try {
            std::rethrow_exception(failure);
        } catch (const std::exception& error) {
            complain("mote-web", error.what());
        }
    }

    void dropOldestWaiting() {
        for (const auto& each : visits) {
            if (each->known || each->dropped) continue;
            each->dropped = true;
            each->close();
            return;
        }
    }

    /// The role that it has shown counts from now on.
    bool welcome(Visit& visit, Role role) {
        if (role == Role::nobody || visit.known) return true;
        if (known >= settings.mostKnown) return false;
        visit.known = true;
        --waiting;
        ++known;
        return true;
    }

    net::awaitable<void> receive(Visits::iterator place) {
        const auto visit = *place;
        limitUnsent(visit->stream.plain().socket());
        visit->stream.plain().expires_after(settings.requestTime);
        if (co_await visit->stream.shakeHands()) co_return;
        beast::flat_buffer buffer(mostHead + mostBody);
        while (true) {
            error_code code;
            http::request_parser<http::string_body> parser;
            parser.header_limit(mostHead);
            parser.body_limit(mostBody);
            visit->stream.plain().expires_after(settings.requestTime);
            co_await http::async_read(visit->stream, buffer, parser, into(code));
            if (code) co_return;
            const auto request = parser.release();
            auto answered = answer(request, access, rooms, settings.page, [this] { tellLink(); });
            if (!welcome(*visit, answered.role))
                answered.with = sentence(http::status::service_unavailable,
                                         "Too many browsers are here already.", request.version(), access);
            if (std::holds_alternative<Upgrade>(answered.with)) {
                co_await bridge(*visit, request, std::get<Upgrade>(answered.with).role);
                co_return;
            }
            if (std::holds_alternative<Await>(answered.with)) {
                const auto wait = std::get<Await>(std::move(answered.with));
                answered.with = co_await roomChanged(request, wait);
            }
            if (request.method() == http::verb::post) wakeRooms();
            if (!co_await send(*visit, std::get<Response>(answered.with), request)) co_return;
        }
    }

    /// The view of a room, when it is another; after a while that it is not.
    net::awaitable<Response> roomChanged(const Request& request, const Await& wait) {
        net::steady_timer timer(context);
        const auto last = std::chrono::steady_clock::now() + roomPatience;
        while (true) {
            const auto* const room = rooms.find(wait.room);
            if (room != nullptr && room->number != wait.after)
                co_return roomResponse(request, access, room->number, room->view);
            if (ending || std::chrono::steady_clock::now() >= last) {
                auto same = roomResponse(request, access, wait.after, {});
                same.result(http::status::no_content);
                co_return same;
            }
            error_code code;
            timer.expires_at(last);
            const auto place = inRooms.insert(inRooms.end(), &timer);
            co_await timer.async_wait(into(code));
            inRooms.erase(place);
        }
    }

    /// Whoever waits in a room looks again.
    void wakeRooms() {
        for (auto* const timer : inRooms) timer->cancel();
    }

    net::awaitable<bool> send(Visit& visit, Response& response, const Request& request) {
        error_code code;
        response.keep_alive(request.keep_alive());
        response.prepare_payload();
        if (request.method() == http::verb::head) response.body().clear();
        visit.stream.plain().expires_after(settings.requestTime);
        co_await http::async_write(visit.stream, response, into(code));
        co_return !code && response.keep_alive();
    }

    net::awaitable<void> bridge(Visit& visit, const Request& request, Role role) {
        visit.stream.plain().expires_never();
        auto& socket = visit.socket.emplace(std::move(visit.stream));
        beast::websocket::stream_base::timeout patience{settings.requestTime, settings.silence, true};
        socket.set_option(patience);
        socket.set_option(
            beast::websocket::stream_base::decorator([](beast::websocket::response_type& response) {
                response.set(http::field::server, "mote-web");
                response.set(http::field::sec_websocket_protocol, "mote.1");
            }));
        socket.auto_fragment(false);
        socket.binary(true);
        error_code code;
        co_await socket.async_accept(request, into(code));
        if (code) co_return;
        socket.text(true);
        const std::string words = role == Role::owner ? R"({"role":"owner"})" : R"({"role":"follower"})";
        co_await socket.async_write(net::buffer(words), into(code));
        socket.binary(true);
        if (code) co_return;
        BridgeSettings way;
        way.connectionFile = settings.connectionFile;
        way.role = role;
        co_await runBridge(socket, std::move(way));
    }

    /// What the kernel keeps for a browser is bounded: the server is to know soon that it does not read.
    template <class Socket>
    static void limitUnsent(Socket& socket) {
        error_code ignored;
        socket.set_option(net::detail::socket_option::integer<IPPROTO_TCP, TCP_NODELAY>(1), ignored);
        socket.set_option(net::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>(mostUnsent),
                          ignored);
    }

    std::string link(Role role) {
        const auto base = settings.access.origins.empty()
                              ? (tls ? "https://" : "http://") + (origin.empty() ? "localhost" : origin)
                              : settings.access.origins.front();
        const auto token = settings.access.trusting ? std::string() : "?token=" + access.makeToken(role);
        return base + settings.access.basePath + token;
    }

    /// The link is good once: the next browser needs another.
    void tellLink() { tellLine("link " + link(Role::owner)); }

    static void tellLine(const std::string& line) {
        fmt::print("{}\n", line);
        std::fflush(stdout);
    }

    GatewaySettings settings;
    net::io_context context{1};
    Access access;
    Acceptor acceptor;
    std::list<net::posix::stream_descriptor> ends;  ///< one becomes readable: it is over
    net::steady_timer pause;
    Rooms rooms;
    std::list<net::steady_timer*> inRooms;  ///< of those who wait for a view
    std::optional<net::ssl::context> tls;
    std::string origin;  ///< of TCP: HOST:PORT
    Visits visits;
    std::size_t waiting = 0, known = 0;
    bool ending = false;
};

Gateway::Gateway(GatewaySettings settings) : impl_(std::make_unique<Impl>(std::move(settings))) {}

Gateway::~Gateway() = default;

Status Gateway::listen() {
    MOTE_RETURN_IF_ERROR(impl_->loadCertificate());
    return impl_->settings.listen.kind == wire::Address::Kind::unixSocket ? impl_->listenUnix()
                                                                          : impl_->listenTcp();
}

std::string Gateway::link(Role role) {
    return impl_->link(role);
}

std::string Gateway::place() const {
    return impl_->origin.empty() ? impl_->settings.listen.path : impl_->origin;
}

void Gateway::run(std::span<const int> descriptors) {
    auto& impl = *impl_;
    for (const int each : descriptors) {
        impl.ends.emplace_back(impl.context, ::dup(each));
        impl.ends.back().async_wait(net::posix::stream_descriptor::wait_read, [&impl](const error_code&) {
            impl.ending = true;
            error_code ignored;
            impl.acceptor.close(ignored);
            impl.pause.cancel();
            impl.wakeRooms();
            for (const auto& visit : impl.visits) visit->close();
        });
    }
    net::co_spawn(
        impl.context, [&impl] { return impl.acceptAll(); }, net::detached);
    while (!impl.ending) impl.context.run_one();
    const auto last = std::chrono::steady_clock::now() + endPatience;
    while (!impl.visits.empty() && std::chrono::steady_clock::now() < last)
        impl.context.run_one_for(endPause);
    if (impl.settings.listen.kind == wire::Address::Kind::unixSocket)
        ::unlink(impl.settings.listen.path.c_str());
}

}  // namespace mote::web
