// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace mote::server {
namespace {

/// A pixel of a grey picture is read as one number before it becomes three.
constexpr std::uint64_t perImagePixel = sizeof(glm::vec3) + sizeof(float);

Result<Loadable<storage::ColorImage>::Value> readImageColors(const storage::Catalogue::Entry& entry) {
    MOTE_ASSIGN_OR_RETURN(auto image, storage::readColors(entry.directory, *entry.manifest, mostImagePixels));
    return std::make_shared<const storage::ColorImage>(std::move(image));
}

}  // namespace

Result<Loadable<storage::ColorImage>> imageColors(const storage::Catalogue::Entry& entry) {
    if (entry.manifest->kind() != "image") {
        return Error{
            ErrorCode::invalidArgument, "dataset",
            fmt::format("\"{}\" is of kind \"{}\", not an image", entry.name, entry.manifest->kind())};
    }
    const auto& image = entry.manifest->image();
    const auto pixels = std::min(std::uint64_t{image.width()} * image.height(), mostImagePixels);
    return Loadable<storage::ColorImage>(
        entry, [pixels](std::uint32_t) { return pixels * perImagePixel; },
        [entry](std::uint32_t, const AnyLoadable::Cancelled&) { return readImageColors(entry); });
}

}  // namespace mote::server
