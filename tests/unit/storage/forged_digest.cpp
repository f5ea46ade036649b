// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/storage/forged_digest.h"

#include <gtest/gtest.h>

#include <fstream>

#include "protocol/base/json.h"
#include "storage/hash.h"
#include "storage/manifest.h"

namespace mote::test {

proto::Digest digestOf(const std::filesystem::path& dataset) {
    proto::Digest digest;
    EXPECT_TRUE(readJsonFile(dataset / "step-000000.digest", digest).ok());
    return digest;
}

void forgeDigest(const std::filesystem::path& dataset, const std::function<void(proto::Digest&)>& change) {
    auto digest = digestOf(dataset);
    change(digest);
    const std::string text = toJson(digest);
    std::ofstream(dataset / "step-000000.digest", std::ios::binary) << text;
    auto manifest = *storage::readManifest(dataset);
    for (auto& file : *manifest.mutable_files()) {
        if (file.name() != "step-000000.digest") continue;
        file.set_size(text.size());
        file.set_xxh3_128(storage::hash128(std::as_bytes(std::span(text))));
    }
    forgeManifest(dataset, toJson(manifest));
}

void forgeManifest(const std::filesystem::path& dataset, const std::string& text) {
    std::ofstream(dataset / storage::manifestName, std::ios::binary) << text;
    std::ofstream(dataset / storage::manifestDigestName, std::ios::binary) << storage::manifestDigest(text);
}

}  // namespace mote::test
