// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/image/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "storage/arrays/array_file.h"

namespace mote::storage {
namespace {

constexpr const char* luminanceArray = "/image/luminance";

/// The means of squares of `factor` pixels a side, smaller ones at the right and lower edge.
Luminance reduced(std::span<const float> values, std::uint32_t width, std::uint32_t height,
                  std::uint32_t factor) {
    Luminance small{(width + factor - 1) / factor, (height + factor - 1) / factor, {}};
    small.values.reserve(std::size_t{small.width} * small.height);
    for (std::uint32_t y = 0; y < height; y += factor) {
        for (std::uint32_t x = 0; x < width; x += factor) {
            const auto right = std::min(x + factor, width);
            const auto bottom = std::min(y + factor, height);
            double sum = 0.0;
            for (std::size_t row = y; row < bottom; ++row) {
                for (std::size_t column = x; column < right; ++column) sum += values[row * width + column];
            }
            small.values.push_back(static_cast<float>(sum / (right - x) / (bottom - y)));
        }
    }
    return small;
}

}  // namespace

Status writeImage(const std::filesystem::path& directory, const Luminance& picture) {
    const ArrayFileContent content{
        {"/image"},
        {arrayContent(luminanceArray, {picture.height, picture.width}, std::span(picture.values))},
        {}};
    return writeArrayFile(directory, imageName, content);
}

Result<Luminance> readImage(const PathBeneath& directory, const proto::Manifest& manifest,
                            std::uint64_t mostPixels) {
    if (!manifest.has_image()) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("is a dataset of kind \"{}\", not an image", manifest.kind())};
    }
    MOTE_ASSIGN_OR_RETURN(const auto file, ArrayFile::open(directory, manifest, imageName));
    const auto width = manifest.image().width();
    const auto height = manifest.image().height();
    MOTE_ASSIGN_OR_RETURN(const auto values, file.get<float>(luminanceArray, {height, width}));
    const auto good = [](float value) { return std::isfinite(value) && value >= 0.0F; };
    bool allGood = std::all_of(values.begin(), values.end(), good);
    const double times = static_cast<double>(values.size()) / static_cast<double>(mostPixels);
    auto picture =
        reduced(values, width, height, std::max(1U, static_cast<std::uint32_t>(std::ceil(std::sqrt(times)))));
    // The copy, too: the file may have been written to between the two.
    allGood = allGood && std::all_of(picture.values.begin(), picture.values.end(), good);
    MOTE_RETURN_IF_ERROR(file.check());
    if (allGood) return picture;
    return Error{ErrorCode::corrupt, file.where(luminanceArray),
                 "holds a luminance that is negative or not finite"};
}

}  // namespace mote::storage
