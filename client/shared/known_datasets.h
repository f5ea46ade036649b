// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server says of its datasets, as films need to know it. Pure functions.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/film/film_datasets.h"

namespace mote::client {

/// Of all that a server has: their steps are known, where they lie is not before they are described.
FilmDatasets knownDatasets(const proto::Catalogue& catalogue);

/// A described one.
FilmDataset knownDataset(const proto::Manifest& manifest);

}  // namespace mote::client
