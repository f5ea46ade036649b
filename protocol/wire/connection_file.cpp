// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/connection_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "protocol/base/json.h"
#include "protocol/wire/address.h"
#include "protocol/wire/framing.h"
#include "protocol/wire/private_file.h"
#include "protocol/wire/tls.h"

namespace mote::wire {
namespace {

bool isToken(const std::string& text) {
    const auto hexadecimal = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
    return !text.empty() && text.size() <= 256 && std::all_of(text.begin(), text.end(), hexadecimal);
}

Status checkContent(const proto::ConnectionFile& content) {
    const auto address = parseAddress(content.address());
    if (!address.ok()) return address.error().within("address");
    if (address->kind == Address::Kind::tcp && !isFingerprint(content.certificate_fingerprint())) {
        return Error{ErrorCode::invalidArgument, "certificateFingerprint",
                     "is no SHA-256, and TCP is not used without TLS"};
    }
    if (!isToken(content.token())) {
        return Error{ErrorCode::invalidArgument, "token", "is not hexadecimal"};
    }
    if (content.protocol_major() != ownVersion.major) {
        return Error{ErrorCode::unsupported, "protocolMajor",
                     fmt::format("the server speaks protocol version {}, this program {}; use programs of "
                                 "the same major version",
                                 content.protocol_major(), ownVersion.major)};
    }
    return success();
}

}  // namespace

Status writeConnectionFile(const std::filesystem::path& path, const proto::ConnectionFile& content) {
    return writePrivateFile(path, toJson(content));
}

Result<proto::ConnectionFile> readConnectionFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readPrivateFile(path));
    proto::ConnectionFile content;
    MOTE_RETURN_IF_ERROR(parseJson(text, content, path.string()));
    MOTE_RETURN_IF_ERROR(checkContent(content), path.string() + ":");
    return content;
}

}  // namespace mote::wire
