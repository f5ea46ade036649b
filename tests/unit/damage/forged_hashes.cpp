// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/forged_hashes.h"

#include <algorithm>
#include <span>
#include <string>
#include <system_error>

#include "protocol/mote.pb.h"
#include "protocol/scene/json.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "tests/unit/damage/file_bytes.h"

namespace mote::test {
namespace {

std::uint64_t elementBytes(const std::string& type) {
    return type == "u64" || type == "f64" ? 8 : type == "u32" || type == "f32" ? 4 : type == "u16" ? 2 : 1;
}

/// The bytes of an array that lie in the file.
std::span<const std::byte> bytesOf(const proto::DigestArray& array, std::span<const std::byte> file) {
    std::uint64_t bytes = elementBytes(array.type());
    for (const auto extent : array.shape()) {
        if (extent > file.size()) return {};
        bytes = std::min<std::uint64_t>(bytes * extent, file.size());
    }
    if (array.offset() > file.size()) return {};
    return file.subspan(array.offset(), std::min<std::uint64_t>(bytes, file.size() - array.offset()));
}

void forgeBlocks(const std::filesystem::path& digestFile) {
    proto::Digest digest;
    if (!readJsonFile(digestFile, digest).ok()) return;
    auto arrays = digestFile;
    const auto content = bytesOfFile(arrays.replace_extension(".h5"));
    for (auto& array : *digest.mutable_arrays()) {
        const auto bytes = bytesOf(array, std::as_bytes(std::span(content)));
        for (int block = 0; block < array.blocks_size(); ++block) {
            const auto begin = static_cast<std::uint64_t>(block) * storage::blockBytes;
            if (begin >= bytes.size()) break;
            const auto size = std::min<std::uint64_t>(storage::blockBytes, bytes.size() - begin);
            array.set_blocks(block, storage::hashBlock(bytes.subspan(begin, size)));
        }
    }
    writeFile(digestFile, toJson(digest));
}

}  // namespace

void forgeHashes(const std::filesystem::path& dataset) {
    for (const auto& entry : std::filesystem::directory_iterator(dataset)) {
        const auto& path = entry.path();
        if (path.extension() == ".digest" && path.filename() != storage::manifestDigestName)
            forgeBlocks(path);
    }
    proto::Manifest manifest;
    const auto path = dataset / storage::manifestName;
    if (readJsonFile(path, manifest).ok()) {
        for (auto& file : *manifest.mutable_files()) {
            std::error_code none;
            if (!std::filesystem::is_regular_file(dataset / file.name(), none)) continue;
            const auto bytes = bytesOfFile(dataset / file.name());
            file.set_size(bytes.size());
            file.set_xxh3_128(storage::hash128(std::as_bytes(std::span(bytes))));
        }
        writeFile(path, toJson(manifest));
    }
    writeFile(dataset / storage::manifestDigestName, storage::manifestDigest(bytesOfFile(path)));
}

}  // namespace mote::test
