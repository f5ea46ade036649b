// SPDX-License-Identifier: GPL-3.0-or-later
//
// Damage that no hash tells: a changed digest, with its hash in the manifest corrected. For tests.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "protocol/mote.pb.h"

namespace mote::test {

/// Of step 0 of a dataset.
proto::Digest digestOf(const std::filesystem::path& dataset);
void forgeDigest(const std::filesystem::path& dataset, const std::function<void(proto::Digest&)>& change);

/// A manifest's text and the digest that belongs to it.
void forgeManifest(const std::filesystem::path& dataset, const std::string& text);

}  // namespace mote::test
