// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/verify.h"

#include <fmt/format.h>

#include "protocol/base/system_error.h"
#include "storage/arrays/array_file.h"
#include "storage/dataset_kind.h"
#include "storage/files/dataset_file.h"
#include "storage/grow_dataset.h"
#include "storage/hash.h"
#include "storage/manifest.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t maxErrors = 1000;

}  // namespace

std::vector<Error> verifyDataset(const fs::path& directory, const std::function<bool()>& cancelled,
                                 const std::function<void(double)>& progress) {
    auto manifest = readManifest(directory);
    if (!manifest.ok()) return {manifest.error()};
    return DatasetVerifier(directory, *std::move(manifest), cancelled, progress).run();
}

std::vector<Error> DatasetVerifier::run() {
    findExtra();
    findKind(manifest_)->verify(*this);
    if (wasCancelled()) return {errors_.back()};
    if (errors_.size() > maxErrors) errors_.resize(maxErrors);
    return errors_;
}

void DatasetVerifier::findExtra() {
    std::error_code code;
    fs::directory_iterator at(directory_, code);
    for (; !code && at != fs::directory_iterator() && errors_.size() < maxErrors; at.increment(code)) {
        const auto name = at->path().filename().string();
        if (name == manifestName || name == manifestDigestName || findFile(manifest_, name)) continue;
        if (manifest_.particles().live() && isOfSomeStep(name)) continue;  // the next one, on its way
        errors_.push_back({ErrorCode::corrupt, at->path().string(), "is no part of the dataset"});
    }
    if (code) errors_.push_back(systemError(code.value(), directory_.string(), "cannot be listed"));
}

void DatasetVerifier::eachStep(int count, const std::function<void(std::uint32_t)>& step) {
    for (int i = 0; i < count && errors_.size() < maxErrors; ++i) {
        step(static_cast<std::uint32_t>(i));
        if (wasCancelled()) return;
        if (progress_) progress_((i + 1.0) / count);
    }
}

/// A file against the manifest; nothing if it is whole.
std::optional<Error> DatasetVerifier::checkFile(const std::string& name) const {
    const auto path = directory_ / name;
    MOTE_ASSIGN_OR_RETURN(const auto file, openRegular(path));
    MOTE_ASSIGN_OR_RETURN(const auto hash, hashFile(file.get(), path, cancelled_));
    const auto& entry = *findFile(manifest_, name);
    if (hash.size == entry.size() && hash.xxh3_128 == entry.xxh3_128()) return std::nullopt;
    return Error{ErrorCode::corrupt, path.string(),
                 hash.size == entry.size()
                     ? "differs from its hash in the manifest"
                     : fmt::format("has {} bytes where the manifest says {}", hash.size, entry.size())};
}

std::optional<bool> DatasetVerifier::files(const std::vector<std::string>& names) {
    bool whole = true;
    for (const auto& name : names) {
        auto error = checkFile(name);
        if (!error) continue;
        whole = false;
        errors_.push_back(*std::move(error));
        if (wasCancelled()) return std::nullopt;
    }
    return whole;
}

bool DatasetVerifier::arrayFile(const std::string& name) {
    const auto whole = files({name + ".digest", name + ".h5"});
    if (!whole) return false;
    const auto opened = ArrayFile::open(directory_, manifest_, name);
    // A file that is not there, or not whole, is said once.
    if (!opened.ok() && !*whole) return false;
    const auto found = opened.ok() ? opened->verify(cancelled_) : std::vector<Error>{opened.error()};
    add(found);
    return *whole && found.empty();
}

}  // namespace mote::storage
