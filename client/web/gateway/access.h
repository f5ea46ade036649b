// SPDX-License-Identifier: GPL-3.0-or-later
//
// Access: who may see what mote-web serves. A link holds a token that is good once; whoever shows it gets a
// cookie, and with that a role. Hosts and origins are checked besides, so that neither a name that was
// pointed at us nor a page of somebody else comes in with a cookie that is not its own. Knows no network;
// owned by the gateway, one thread.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::web {

/// Of a browser. A follower looks at datasets and follows sessions; it changes nothing.
enum class Role { nobody, follower, owner };

struct AccessSettings {
    /// Where a proxy shows us, from "/" to "/"; one that strips it is answered alike.
    std::string basePath = "/";
    /// Of pages, besides our own address: "https://hub.example.org".
    std::vector<std::string> origins;
    /// Whose pages may frame ours, besides our own origin.
    std::vector<std::string> frameAncestors;
    /// Hosts as which we listen, besides loopback's names; "127.0.0.2:8000".
    std::vector<std::string> hosts;
    /// Any host: nobody reaches our socket but a proxy of the same user.
    bool anyHost = false;
    /// Whoever reaches the socket is the owner: a proxy before it asks who they are.
    bool trusting = false;
    /// The owner is a follower, too.
    bool readOnly = false;
    /// Browsers reach us by https.
    bool encrypted = false;
};

/// What of a request says from where it comes.
struct Caller {
    std::string_view host, origin, forwardedHost, cookies;
};

class Access {
  public:
    explicit Access(AccessSettings settings);

    const AccessSettings& settings() const { return settings_; }

    /// A token for one browser. Of those that nobody used the last 64 are good.
    std::string makeToken(Role role);
    /// The role that it gives, once; nobody for one that is none, or was used.
    Role useToken(std::string_view token);

    /// The value of Set-Cookie: for scripts not to be seen, for our own path alone, which browsers take from
    /// where they asked, as only they know what a proxy strips. `secure`: they asked by https.
    std::string cookie(Role role, bool secure) const;
    Role roleOf(const Caller& caller) const;

    /// Whether the name by which we were asked is one of ours.
    bool knowsHost(std::string_view host) const;
    /// Whether the page that asks is one of ours.
    bool knowsOrigin(const Caller& caller) const;

    /// What follows the base path, from "/" on: also where a proxy stripped it. Nothing: the base without its
    /// last slash.
    std::optional<std::string_view> pathBelowBase(std::string_view path) const;
    /// Content-Security-Policy of what is asked by this host.
    std::string policy(std::string_view host) const;

    /// Whether who has the role may say this. Errors: permissionDenied.
    static Status mayAsk(Role role, const proto::ClientMessage& message);

  private:
    AccessSettings settings_;
    std::string cookieName_;
    std::string ownerSecret_, followerSecret_;
    std::deque<std::pair<std::string, Role>> tokens_;
};

/// "HOST" or "HOST:PORT" without the port; an IPv6 address keeps its brackets.
std::string_view hostName(std::string_view host);
/// Whether it is "http" or "https", "://" and a host that CSP can name.
bool isOrigin(std::string_view text);

}  // namespace mote::web
