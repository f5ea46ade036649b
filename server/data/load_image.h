// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is loaded of images to be shown. A value; `entry` is one of the catalogue's.
#pragma once

#include "server/data/loadable.h"
#include "storage/image/image_file.h"

namespace mote::server {

/// An image in memory has no more pixels; larger ones are averaged down by a whole number.
inline constexpr std::uint64_t mostImagePixels = std::uint64_t{1} << 23;

/// A picture's colours. Errors: invalidArgument (a dataset of another kind).
Result<Loadable<storage::ColorImage>> imageColors(const storage::Catalogue::Entry& entry);

}  // namespace mote::server
