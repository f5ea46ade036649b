// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a job is recognised by: a request that was there before, of inputs that are the same still, and what
// it has made. Pure functions, but for looking at files (never into them).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::server {

/// Of the whole request, and of the identity of each file and dataset that it reads: 32 hexadecimal digits,
/// the same for the same request as long as nothing that it reads is changed or replaced. Empty where that
/// cannot be known (an input is away, or a folder of very many files): then it is like no other. `uploads`:
/// the root of files that this server alone writes to, and gives other names to; empty: none.
std::string requestDigest(const proto::JobRequest& request, const storage::Roots& roots,
                          std::string_view uploads = {});

/// Tells what is there from whatever may once take its place; empty: nothing is there.
std::string identityOf(const std::filesystem::path& path);

}  // namespace mote::server
