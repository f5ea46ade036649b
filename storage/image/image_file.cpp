// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/image/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <utility>

#include "storage/arrays/array_file.h"

namespace mote::storage {
namespace {

constexpr const char* luminanceArray = "/image/luminance";
constexpr const char* colorArray = "/image/color";

/// A sum of values in double precision.
template <class T>
struct Sum;
template <>
struct Sum<float> {
    using Type = double;
};
template <>
struct Sum<glm::vec3> {
    using Type = glm::dvec3;
};

/// The means of squares of `factor` pixels a side, smaller ones at the right and lower edge, row by row.
/// `valueAt`: of a pixel by its number.
template <class T, class ValueAt>
std::vector<T> reduced(std::uint32_t width, std::uint32_t height, std::uint32_t factor, ValueAt valueAt) {
    using Total = typename Sum<T>::Type;
    std::vector<T> small;
    small.reserve(std::size_t{(width + factor - 1) / factor} * ((height + factor - 1) / factor));
    for (std::uint32_t y = 0; y < height; y += factor) {
        for (std::uint32_t x = 0; x < width; x += factor) {
            const auto right = std::min(x + factor, width);
            const auto bottom = std::min(y + factor, height);
            Total sum(0.0);
            for (std::size_t row = y; row < bottom; ++row) {
                for (std::size_t column = x; column < right; ++column)
                    sum += Total(valueAt(row * width + column));
            }
            small.push_back(T(sum / static_cast<double>(right - x) / static_cast<double>(bottom - y)));
        }
    }
    return small;
}

/// By how much a picture is averaged down that may have so many pixels.
std::uint32_t factorFor(std::uint32_t width, std::uint32_t height, std::uint64_t mostPixels) {
    const double times = static_cast<double>(width) * height / static_cast<double>(mostPixels);
    return std::max(1U, static_cast<std::uint32_t>(std::ceil(std::sqrt(times))));
}

/// The file of an image. Errors: as readImage.
Result<ArrayFile> openImage(const PathBeneath& directory, const proto::Manifest& manifest) {
    if (manifest.has_image()) return ArrayFile::open(directory, manifest, imageName);
    return Error{ErrorCode::invalidArgument, directory.string(),
                 fmt::format("is a dataset of kind \"{}\", not an image", manifest.kind())};
}

bool isLight(float value) {
    return std::isfinite(value) && value >= 0.0F;
}

bool isLight(const glm::vec3& value) {
    return isLight(value.x) && isLight(value.y) && isLight(value.z);
}

/// What was read and averaged, or that it is none. The copy is asked, too: the file may have been written to
/// meanwhile; and the file is, for what became of it while it was read.
template <class T>
Result<std::vector<T>> checkedLight(std::vector<T> values, bool allGood, const ArrayFile& file,
                                    const char* array) {
    MOTE_RETURN_IF_ERROR(file.check());
    if (allGood && std::all_of(values.begin(), values.end(), [](const T& value) { return isLight(value); }))
        return values;
    return Error{ErrorCode::corrupt, file.where(array), "holds a light that is negative or not finite"};
}

float ofHalf(std::uint16_t bits) {
    return std::bit_cast<float>(std::uint32_t{bits} << 13U) * 0x1p112F;
}

/// Neither negative nor infinite nor no number at all.
bool isLightBits(std::uint16_t bits) {
    return bits < 0x7c00U;
}

}  // namespace

std::uint16_t halfBits(float light) {
    constexpr float most = 65504.0F;
    return glm::packHalf1x16(std::clamp(light, 0.0F, most));
}

Status writeImage(const std::filesystem::path& directory, const Luminance& picture,
                  std::span<const std::uint16_t> colors) {
    ArrayFileContent content{
        {"/image"},
        {arrayContent(luminanceArray, {picture.height, picture.width}, std::span(picture.values))},
        {}};
    if (!colors.empty())
        content.arrays.push_back(arrayContent(colorArray, {picture.height, picture.width, 3}, colors));
    return writeArrayFile(directory, imageName, content);
}

Result<Luminance> readImage(const PathBeneath& directory, const proto::Manifest& manifest,
                            std::uint64_t mostPixels) {
    MOTE_ASSIGN_OR_RETURN(const auto file, openImage(directory, manifest));
    const auto width = manifest.image().width();
    const auto height = manifest.image().height();
    MOTE_ASSIGN_OR_RETURN(const auto values, file.get<float>(luminanceArray, {height, width}));
    const bool allGood = std::all_of(values.begin(), values.end(), [](float each) { return isLight(each); });
    const auto factor = factorFor(width, height, mostPixels);
    MOTE_ASSIGN_OR_RETURN(
        auto small, checkedLight(reduced<float>(width, height, factor, [&](auto i) { return values[i]; }),
                                 allGood, file, luminanceArray));
    return Luminance{(width + factor - 1) / factor, (height + factor - 1) / factor, std::move(small)};
}

Result<ColorImage> readColors(const PathBeneath& directory, const proto::Manifest& manifest,
                              std::uint64_t mostPixels) {
    MOTE_ASSIGN_OR_RETURN(const auto file, openImage(directory, manifest));
    const auto width = manifest.image().width();
    const auto height = manifest.image().height();
    const auto factor = factorFor(width, height, mostPixels);
    ColorImage picture{(width + factor - 1) / factor,
                       (height + factor - 1) / factor,
                       static_cast<double>(width) / factor,
                       static_cast<double>(height) / factor,
                       {}};
    if (!file.has(colorArray)) {
        MOTE_ASSIGN_OR_RETURN(const auto grey, readImage(directory, manifest, mostPixels));
        for (const float value : grey.values) picture.values.emplace_back(value);
        return picture;
    }
    MOTE_ASSIGN_OR_RETURN(const auto halves, file.get<std::uint16_t>(colorArray, {height, width, 3}));
    const bool allGood = std::all_of(halves.begin(), halves.end(), isLightBits);
    const auto valueAt = [&](std::size_t i) {
        return glm::vec3(ofHalf(halves[3 * i]), ofHalf(halves[3 * i + 1]), ofHalf(halves[3 * i + 2]));
    };
    MOTE_ASSIGN_OR_RETURN(picture.values, checkedLight(reduced<glm::vec3>(width, height, factor, valueAt),
                                                       allGood, file, colorArray));
    return picture;
}

}  // namespace mote::storage
