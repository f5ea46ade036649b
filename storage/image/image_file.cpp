// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/image/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "storage/arrays/array_file.h"

namespace mote::storage {
namespace {

constexpr const char* luminanceArray = "/image/luminance";

}  // namespace

Status writeImage(const std::filesystem::path& directory, const Luminance& picture) {
    const ArrayFileContent content{
        {"/image"},
        {arrayContent(luminanceArray, {picture.height, picture.width}, std::span(picture.values))},
        {}};
    return writeArrayFile(directory, imageName, content);
}

Result<Luminance> readImage(const std::filesystem::path& directory, const proto::Manifest& manifest) {
    if (!manifest.has_image()) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("is a dataset of kind \"{}\", not an image", manifest.kind())};
    }
    const auto file = ArrayFile::open(directory, manifest, imageName);
    if (!file.ok()) return file.error();
    Luminance picture{manifest.image().width(), manifest.image().height(), {}};
    const auto values = file->get<float>(luminanceArray, {picture.height, picture.width});
    if (!values.ok()) return values.error();
    picture.values.assign(values->begin(), values->end());
    MOTE_RETURN_IF_ERROR(file->check());
    const auto good = [](float value) { return std::isfinite(value) && value >= 0.0F; };
    if (std::all_of(picture.values.begin(), picture.values.end(), good)) return picture;
    return Error{ErrorCode::corrupt, file->where(luminanceArray),
                 "holds a luminance that is negative or not finite"};
}

}  // namespace mote::storage
