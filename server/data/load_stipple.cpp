// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_stipple.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "protocol/scene/dataset.h"
#include "server/data/load_image.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::server {
namespace {

using storage::Catalogue;

// Estimates of what is held while something is loaded, in bytes. What is mapped as it is read is the kernel's
// to take back.
constexpr std::uint64_t perWord = 4;  // a float or an index
constexpr std::uint64_t perPoint = 3 * perWord + 3 * perWord + perWord + perWord + 1 + 8;  // of a hierarchy
constexpr std::uint64_t perMove = perWord + 3 * perWord;
constexpr std::uint64_t perReplayPoint = 3 * perWord + 3 * perWord + perWord + perWord + perWord;
constexpr std::uint64_t perPackedMove = 12;  // a few, in a vector that grows
constexpr std::uint64_t perTilePoint = 4 * perWord;
constexpr std::uint64_t tileCells = 64 * (64 * perWord);
constexpr std::uint64_t perStippleVertex = 6 * perWord, perStippleTriangle = 4 * perWord,
                        perStippleEdge = 4 * perWord;
constexpr std::uint64_t perRayVertex = 3 * perWord;
constexpr std::uint64_t perRayTriangle = 256;  // of Embree's tree while it is built
constexpr std::uint64_t perPixel = 4 + 8;      // its value and its entry in the summed-area table

Status checkKind(const Catalogue::Entry& entry, std::string_view kind, std::string_view what) {
    if (entry.manifest->kind() == kind) return success();
    return Error{ErrorCode::invalidArgument, "dataset",
                 fmt::format("\"{}\" is of kind \"{}\", not {}", entry.name, entry.manifest->kind(), what)};
}

Status checkStipple(const Catalogue::Entry& entry) {
    return checkKind(entry, "stipple", "a stipple hierarchy");
}

std::uint64_t hierarchyBytes(const proto::StippleManifest& stipple) {
    return stipple.points() * perPoint + stipple.moves() * perMove;
}

std::uint64_t surfaceBytes(const proto::Manifest& manifest) {
    const auto& stipple = manifest.stipple();
    const auto& mesh = manifest.mesh();
    const auto replay = stipple.points() * perReplayPoint + stipple.moves() * perPackedMove;
    const auto rays = mesh.vertices() * (perStippleVertex + perRayVertex) +
                      mesh.triangles() * (perStippleTriangle + perRayTriangle) +
                      mesh.edges() * perStippleEdge;
    return replay + std::max(hierarchyBytes(stipple), rays);
}

/// The hierarchy is gone when the mesh is read.
Result<render::StippleReplay> readReplay(const Catalogue::Entry& entry) {
    MOTE_ASSIGN_OR_RETURN(const auto hierarchy, storage::readHierarchy(entry.directory, *entry.manifest));
    return render::StippleReplay(hierarchy);
}

Result<Loadable<render::StippleSurface>::Value> readSurface(const Catalogue::Entry& entry) {
    MOTE_ASSIGN_OR_RETURN(auto replay, readReplay(entry));
    MOTE_ASSIGN_OR_RETURN(const auto mesh, storage::readMesh(entry.directory, *entry.manifest));
    return std::make_shared<const render::StippleSurface>(
        std::move(replay), render::SurfaceRays(mesh.positions, mesh.triangles),
        datasetBounds(*entry.manifest), entry.manifest->stipple().area());
}

Result<Loadable<render::PlaneTiles>::Value> readPlane(const Catalogue::Entry& entry) {
    MOTE_ASSIGN_OR_RETURN(auto hierarchy, storage::readHierarchy(entry.directory, *entry.manifest));
    return std::make_shared<const render::PlaneTiles>(
        std::make_shared<const storage::StippleHierarchy>(std::move(hierarchy)));
}

Result<Loadable<render::PixelMap>::Value> readLuminance(const Catalogue::Entry& entry) {
    MOTE_ASSIGN_OR_RETURN(auto image, storage::readImage(entry.directory, *entry.manifest, mostImagePixels));
    return std::make_shared<const render::PixelMap>(image.width, image.height, std::move(image.values));
}

/// What has no steps.
template <class T>
Loadable<T> single(const Catalogue::Entry& entry, std::uint64_t bytes,
                   Result<std::shared_ptr<const T>> (*read)(const Catalogue::Entry&)) {
    return {entry, [bytes](std::uint32_t) { return bytes; },
            [entry, read](std::uint32_t, const AnyLoadable::Cancelled&) { return read(entry); }};
}

}  // namespace

Result<Loadable<render::StippleSurface>> stippleSurface(const Catalogue::Entry& entry) {
    MOTE_RETURN_IF_ERROR(checkStipple(entry));
    if (entry.manifest->stipple().domain() != proto::StippleManifest::SURFACE) {
        return Error{ErrorCode::unsupported, "dataset",
                     "its points lie on the plane: they stipple an image, which is not given"};
    }
    return single(entry, surfaceBytes(*entry.manifest), readSurface);
}

Result<Loadable<render::PlaneTiles>> stipplePlane(const Catalogue::Entry& entry) {
    MOTE_RETURN_IF_ERROR(checkStipple(entry));
    const auto& stipple = entry.manifest->stipple();
    if (stipple.domain() != proto::StippleManifest::PLANE) {
        return Error{ErrorCode::invalidArgument, "dataset",
                     "a picture is stippled with a hierarchy of the plane, not with one of a surface"};
    }
    const auto bytes = hierarchyBytes(stipple) + stipple.points() * perTilePoint + tileCells;
    return single(entry, bytes, readPlane);
}

Result<Loadable<render::PixelMap>> imageLuminance(const Catalogue::Entry& entry) {
    MOTE_RETURN_IF_ERROR(checkKind(entry, "image", "an image"));
    const auto& image = entry.manifest->image();
    const auto pixels = std::uint64_t{image.width()} * image.height();
    const auto kept = std::min(pixels, mostImagePixels);
    return single(entry, kept * perPixel + (std::uint64_t{image.width()} + image.height() + 1) * 8,
                  readLuminance);
}

}  // namespace mote::server
