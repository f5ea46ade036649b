// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/identity_file.h"

#include "protocol/wire/private_file.h"

namespace mote::server {

Result<wire::TlsIdentity> readIdentity(const std::filesystem::path& stateDirectory) {
    const auto path = stateDirectory / "tls.pem";
    auto pem = wire::readPrivateFile(path);
    if (!pem.ok() && pem.error().code == ErrorCode::notFound) {
        MOTE_ASSIGN_OR_RETURN(const auto fresh, wire::TlsIdentity::makePem());
        MOTE_RETURN_IF_ERROR(wire::writePrivateFile(path, fresh));
        pem = fresh;
    }
    if (!pem.ok()) return pem.error();
    auto identity = wire::TlsIdentity::parse(*pem);
    if (identity.ok()) return identity;
    return Error{identity.error().code, path.string(),
                 identity.error().message + "; move it away, and the server makes another"};
}

}  // namespace mote::server
