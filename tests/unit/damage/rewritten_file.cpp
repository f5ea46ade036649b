// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/rewritten_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "protocol/base/json.h"
#include "protocol/mote.pb.h"
#include "storage/blocks/mapped_file.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "tests/unit/damage/damaged_dataset.h"

namespace mote::test {

RewrittenFile::RewrittenFile(const std::filesystem::path& path)
    : original_(bytesOfFile(path)), file_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)) {}

RewrittenFile::~RewrittenFile() {
    ::close(file_);
}

void RewrittenFile::write(std::size_t at, std::string_view bytes) const {
    const auto size = std::min(bytes.size(), original_.size() - at);
    EXPECT_EQ(::pwrite(file_, bytes.data(), size, static_cast<off_t>(at)), static_cast<ssize_t>(size));
}

void RewrittenFile::cutOff(std::size_t at) const {
    EXPECT_EQ(::ftruncate(file_, static_cast<off_t>(at)), 0);
}

void disturb(const RewrittenFile& file, const std::string& other, Random& random) {
    const auto at = random.below(file.original().size());
    const auto size = 1 + random.below(random.oneOf<std::uint64_t>({8, 4096, 1 << 17}));
    std::string bytes;
    switch (random.below(4)) {
        case 0:
            for (std::uint64_t i = 0; i < size; ++i) bytes.push_back(static_cast<char>(random.next()));
            break;
        case 1:
            bytes.assign(size, random.oneOf<char>({'\xff', '\0', '\x7f'}));
            break;
        case 2:
            bytes = other.substr(std::min(at, other.size() - 1), size);
            break;
        default:
            file.restore();
            return;
    }
    file.write(at, bytes);
}

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

namespace {

using Files = std::vector<std::unique_ptr<RewrittenFile>>;

Files filesOf(const DamagedDataset& dataset) {
    Files files;
    for (const auto& [name, bytes] : dataset.files())
        files.push_back(std::make_unique<RewrittenFile>(dataset.path() / name));
    return files;
}

void change(const RewrittenFile& file, const std::string& other, Random& random) {
    if (random.chance(0.25)) return file.cutOff(random.below(file.original().size()));
    disturb(file, other, random);
}

/// Waits for a moment, shorter ones as likely as longer ones, and changes the files until the answer is
/// there.
std::uint64_t disturbUntil(const std::atomic<bool>& answered, const Files& files, Random random) {
    constexpr int longest = 13;  // yields, as a power of two: some milliseconds
    constexpr std::uint64_t most = 6;
    for (auto left = random.magnitude(0, longest); left > 0.0 && !answered; left -= 1.0)
        std::this_thread::yield();
    const auto wanted = 1 + random.below(most);
    std::uint64_t writes = 0;
    for (; writes < wanted && !answered; ++writes) {
        const auto& other = files[random.below(files.size())]->original();
        change(*files[random.below(files.size())], other, random);
    }
    return writes;
}

}  // namespace

std::uint64_t askWhileRewritten(DamagedDataset& dataset, std::uint64_t questions, std::uint64_t seed) {
    storage::catchMappingFaults();
    const auto files = filesOf(dataset);
    Random random(seed, 21);
    std::uint64_t writes = 0;
    for (std::uint64_t i = 0; i < questions; ++i) {
        std::atomic<bool> answered{false};
        std::thread writer([&, own = Random(seed, 22 + i)] { writes += disturbUntil(answered, files, own); });
        dataset.ask(random);
        answered = true;
        writer.join();
        for (const auto& file : files) file->restore();
    }
    return writes;
}

}  // namespace mote::test
