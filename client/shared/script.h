// SPDX-License-Identifier: GPL-3.0-or-later
//
// Reads scripts and saved views, each of which may stand for the other. Everything that can be wrong in one
// by itself is found here, before a server is asked for anything. Pure, but for the files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/film/film_datasets.h"

namespace mote::client {

/// A script that is valid in itself; a saved view is a script of one. Errors name the file and the field's
/// path, "views.json: views[2].layers[0].step": those of readJsonFile, checkScript and parseView. `width`,
/// `height`: pixels of a saved view that says none.
Result<proto::Script> readScript(const std::filesystem::path& path, std::uint32_t width = 0,
                                 std::uint32_t height = 0);

struct SavedView {
    proto::View view;
    std::string note;  ///< what of the file it is not, one sentence; empty if it is all of it
};

/// A saved view, which may leave its size to the window, or the first view of a script. Errors as
/// readScript().
Result<SavedView> readSavedView(const std::filesystem::path& path);

// What a server says of its datasets, as films need to know it. Pure functions.

/// Returns what a server says of all its datasets: their steps are known, where they lie is not before they
/// are described.
FilmDatasets knownDatasets(const proto::Catalogue& catalogue);

/// Returns what its manifest says of a dataset.
FilmDataset knownDataset(const proto::Manifest& manifest);

}  // namespace mote::client
