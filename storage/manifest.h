// SPDX-License-Identifier: GPL-3.0-or-later
//
// manifest.json: what a dataset is and which files it has, with their sizes and hashes. Read from files that
// nobody vouches for, so every field that a program relies on is checked here. Pure, but for the files.
// docs/FORMAT.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

inline constexpr std::uint32_t formatVersion = 1;
inline constexpr const char* manifestName = "manifest.json";
/// Its own hash, as `xxhsum -H2` prints and checks it.
inline constexpr const char* manifestDigestName = "manifest.digest";
inline constexpr const char* datasetSuffix = ".mote";
/// Steps of one dataset; keeps a manifest well below manifestLimit.
inline constexpr int maxSteps = 10000;
inline constexpr std::size_t manifestLimit = std::size_t{1} << 26;  ///< bytes
inline constexpr std::uint32_t maxOctreeLevel = 16;
inline constexpr std::uint32_t maxVolumeLevel = 8;
inline constexpr int densityHistogramBins = 128;

/// Whether the fields are complete, in range and agree with each other; looks at no file. Errors: corrupt,
/// unsupported (a kind or format of a later version), with the field's path.
Status checkManifest(const proto::Manifest& manifest);

/// Reads and checks `directory`/manifest.json, also against its digest if that is there: datasets made
/// before it was have none. Errors: notFound, permissionDenied, corrupt, unsupported.
Result<proto::Manifest> readManifest(const PathBeneath& directory);

/// Checks, writes and syncs `directory`/manifest.json and, unless the dataset is live, its digest, new files.
/// Errors: as checkManifest, resourceExhausted (disk full), permissionDenied, alreadyExists.
Status writeManifest(const std::filesystem::path& directory, const proto::Manifest& manifest);

/// What manifest.digest says of a manifest's text.
std::string manifestDigest(std::string_view text);

/// The entry of a file, nullptr if the manifest has none.
const proto::FileEntry* findFile(const proto::Manifest& manifest, const std::string& name);

}  // namespace mote::storage
