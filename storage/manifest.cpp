// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/manifest.h"

#include <fmt/format.h>

#include <span>

#include "protocol/base/json.h"
#include "storage/dataset_kind.h"
#include "storage/files/dataset_file.h"
#include "storage/hash.h"

namespace mote::storage {
namespace {

bool isHex32(const std::string& text) {
    return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

Status checkFiles(const proto::Manifest& manifest, FileNames& names) {
    for (int i = 0; i < manifest.files_size(); ++i) {
        const auto& file = manifest.files(i);
        const auto where = fmt::format("files[{}]", i);
        if (!isPlainName(file.name()) || file.name() == manifestName || file.name() == manifestDigestName)
            return corrupt(where + ".name", "is not the name of a file in the dataset");
        if (!names.insert(file.name()).second) return corrupt(where + ".name", "names a file twice");
        if (!isHex32(file.xxh3_128())) return corrupt(where + ".xxh3128", "must be 32 hexadecimal digits");
    }
    return success();
}

/// Nobody else keeps the manifest's hash. A dataset may have none: it was made before there was one.
Status checkDigest(const PathBeneath& directory, std::string_view text) {
    constexpr std::size_t most = 256;
    const auto digest = readWhole(directory / manifestDigestName, most);
    if (!digest.ok()) return digest.error().code == ErrorCode::notFound ? success() : Status(digest.error());
    if (*digest == manifestDigest(text)) return success();
    return corrupt((directory / manifestName).string(),
                   fmt::format("differs from its digest in {}: the dataset is damaged; copy or make it again",
                               manifestDigestName));
}

Error inFile(const std::filesystem::path& path, Error error) {
    error.where = path.string() + ": " + error.where;
    return error;
}

}  // namespace

Status checkManifest(const proto::Manifest& manifest) {
    if (manifest.format() > formatVersion) {
        return Error{ErrorCode::unsupported, "format",
                     fmt::format("is {}, from a later version of Mote than this one ({})", manifest.format(),
                                 formatVersion)};
    }
    if (manifest.format() != formatVersion) return corrupt("format", "is missing or wrong");
    FileNames files;
    MOTE_RETURN_IF_ERROR(checkFiles(manifest, files));
    if (const auto* kind = findKind(manifest)) return kind->check(manifest, files);
    return Error{ErrorCode::unsupported, "kind",
                 fmt::format("\"{}\" is not a kind of dataset that this version reads", manifest.kind())};
}

Result<proto::Manifest> readManifest(const PathBeneath& directory) {
    const auto path = directory / manifestName;
    MOTE_ASSIGN_OR_RETURN(const auto text, readWhole(path, manifestLimit));
    proto::Manifest manifest;
    const auto parsed = parseJson(text, manifest, path.string());
    // That of a live dataset may have been replaced since, with a digest of the new one.
    if (!parsed.ok() || !manifest.particles().live()) MOTE_RETURN_IF_ERROR(checkDigest(directory, text));
    // A dataset's own file that is not what it must be is damage, not somebody's wrong argument.
    if (!parsed.ok()) return Error{ErrorCode::corrupt, parsed.error().where, parsed.error().message};
    const auto checked = checkManifest(manifest);
    if (!checked.ok()) return inFile(path.path(), checked.error());
    return manifest;
}

Status writeManifest(const std::filesystem::path& directory, const proto::Manifest& manifest) {
    const auto path = directory / manifestName;
    const auto checked = checkManifest(manifest);
    if (!checked.ok()) return inFile(path, checked.error());
    const std::string text = toJson(manifest);
    if (text.size() > manifestLimit) {
        return Error{ErrorCode::resourceExhausted, path.string(), "would be larger than a manifest may be"};
    }
    // One rename replaces the manifest of a live dataset, and could not replace two files.
    if (!manifest.particles().live())
        MOTE_RETURN_IF_ERROR(writeNewFile(directory / manifestDigestName, manifestDigest(text)));
    return writeNewFile(path, text);
}

std::string manifestDigest(std::string_view text) {
    return fmt::format("{}  {}\n", hash128(std::as_bytes(std::span(text))), manifestName);
}

const proto::FileEntry* findFile(const proto::Manifest& manifest, const std::string& name) {
    for (const auto& file : manifest.files()) {
        if (file.name() == name) return &file;
    }
    return nullptr;
}

}  // namespace mote::storage
