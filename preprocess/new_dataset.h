// SPDX-License-Identifier: GPL-3.0-or-later
//
// What jobs that make a dataset have in common: how its manifest begins and what it calls their inputs, and
// how the dataset comes into its place. Functions without state.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/dataset_writer.h"

namespace mote::prep {

/// Where an output will lie in the end: that of a server's job is made in a folder beside its place.
std::filesystem::path finalPlace(const std::filesystem::path& output);

/// A manifest of this kind, with the request but for its output. `title`: if the request has none.
proto::Manifest beginManifest(const char* kind, const proto::JobRequest& request, const std::string& title);

/// The input as seen from the folder that is to hold the dataset `output`, so that a manifest does not depend
/// on where or how it was made.
std::string portableInput(const std::filesystem::path& input, const std::filesystem::path& output);

/// Puts the dataset into its place; the manifest has its files then. Errors: cancelled, those of
/// DatasetWriter::publish.
Status publishDataset(storage::DatasetWriter& writer, proto::Manifest& manifest, const Progress& progress);

/// The same, with NAME.h5 and NAME.digest of each of `names` for its files. Errors: also those of
/// DatasetWriter::add.
Result<proto::Manifest> finishDataset(storage::DatasetWriter& writer,
                                      std::initializer_list<std::string_view> names, proto::Manifest manifest,
                                      Progress& progress);

}  // namespace mote::prep
