// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <span>

#include "protocol/base/json.h"
#include "protocol/scene/dataset.h"
#include "storage/dataset_kind.h"
#include "storage/dataset_writer.h"
#include "storage/hash.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/storage_error.h"
#include "storage/verify.h"
#include "tests/fuzz/input_folder.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/require.h"
#include "tests/support/dataset_content.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

using Files = std::map<std::string, std::string>;

std::span<const std::byte> bytesOf(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

/// The hashes of what lies in the file where the digest says that arrays do.
void forgeBlocks(proto::Digest& digest, std::string_view file) {
    for (auto& array : *digest.mutable_arrays()) {
        std::uint64_t at = array.offset();
        for (auto& block : *array.mutable_blocks()) {
            if (at >= file.size()) break;
            // Of the last one the digest does not say how long it is: the shape does.
            std::uint64_t left = array.type() == "u8"    ? 1
                                 : array.type() == "u16" ? 2
                                 : array.type() == "u64" ? 8
                                                         : 4;
            for (const auto extent : array.shape()) left = extent > file.size() ? file.size() : left * extent;
            left = std::min<std::uint64_t>(left, file.size()) - std::min(left, at - array.offset());
            const auto size = std::min({left, storage::blockBytes, file.size() - at});
            block = storage::hashBlock(bytesOf(file.substr(at, size)));
            at += storage::blockBytes;
        }
    }
}

/// Makes all hashes anew where there is something that can hold them.
void forge(Files& files) {
    for (auto& [name, text] : files) {
        const fs::path path = name;
        const auto file = files.find(path.stem().string() + ".h5");
        proto::Digest digest;
        if (path.extension() != ".digest" || file == files.end()) continue;
        if (!parseJson(text, digest, name).ok()) continue;
        forgeBlocks(digest, file->second);
        text = toJson(digest);
    }
    const auto found = files.find(storage::manifestName);
    proto::Manifest manifest;
    if (found == files.end()) return;
    if (parseJson(found->second, manifest, found->first).ok()) {
        for (auto& entry : *manifest.mutable_files()) {
            const auto file = files.find(entry.name());
            if (file == files.end()) continue;
            entry.set_size(file->second.size());
            entry.set_xxh3_128(storage::hash128(bytesOf(file->second)));
        }
        found->second = toJson(manifest);
    }
    files[storage::manifestDigestName] = storage::manifestDigest(found->second);
}

/// What is written again is loaded as it was.
template <class Write>
void writeAgain(const fs::path& dataset, const proto::Manifest& manifest, const Write& write) {
    const auto again = dataset.parent_path() / "again.mote";
    auto writer = storage::DatasetWriter::create(again);
    require(writer.ok() && write(writer->directory()).ok());
    for (const auto& entry : fs::directory_iterator(writer->directory()))
        require(writer->add(entry.path().filename().string()).ok());
    auto described = manifest;
    described.clear_files();  // the writer tells of those that it was given
    require(writer->publish(described).ok() && storage::verifyDataset(again).empty());
}

/// Of kinds that are loaded as a whole.
void writeAgain(const fs::path& dataset, const proto::Manifest& manifest) {
    if (manifest.kind() == "image") {
        const auto image = *storage::readImage(dataset, manifest);
        writeAgain(dataset, manifest, [&](const fs::path& to) { return storage::writeImage(to, image); });
    }
    if (manifest.kind() == "mesh") {
        const auto mesh = *storage::readMesh(dataset, manifest);
        writeAgain(dataset, manifest, [&](const fs::path& to) { return storage::writeMesh(to, mesh); });
    }
    if (manifest.kind() == "stipple" && !manifest.has_mesh()) {
        const auto hierarchy = *storage::readHierarchy(dataset, manifest);
        writeAgain(dataset, manifest,
                   [&](const fs::path& to) { return storage::writeHierarchy(to, hierarchy); });
    }
}

std::string load(const fs::path& dataset, const proto::Manifest& manifest) {
    constexpr std::uint64_t plenty = 1 << 26, little = 1 << 16;
    try {
        const auto content = contentOfDataset(dataset);
        require(contentOfDataset(dataset, std::make_shared<storage::BlockBudget>(plenty)) == content);
        writeAgain(dataset, manifest);
        require(contentOfDataset(dataset, std::make_shared<storage::BlockBudget>(little)) == content);
    } catch (const storage::StorageError& error) {
        const bool tooMuch = error.error().code == ErrorCode::resourceExhausted;
        return tooMuch ? "" : error.error().toString();
    }
    return "";
}

}  // namespace

std::string datasetInput(std::string_view input) {
    auto files = filesOf(input);
    // With this one beside them hashes stay as they are.
    if (files.erase("unforged") == 0) forge(files);
    const InputFolder folder;
    const auto dataset = folder.path() / "a.mote";
    fs::create_directory(dataset);
    for (const auto& [name, bytes] : files) folder.write("a.mote/" + name, bytes);
    const auto errors = storage::verifyDataset(dataset);
    if (!errors.empty()) return errors.front().toString();
    const auto manifest = storage::readManifest(dataset);
    require(manifest.ok());
    const auto& kind = *storage::findKind(*manifest);
    require(!kind.describe(*manifest).empty() && !kind.summarize(*manifest).text.empty());
    const auto box = datasetBounds(*manifest);
    for (int axis = 0; axis < 3; ++axis)
        require(std::isfinite(box.min[axis]) && std::isfinite(box.max[axis]));
    return load(dataset, *manifest);
}

}  // namespace mote::test
