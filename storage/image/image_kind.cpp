// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "storage/dataset_kind.h"
#include "storage/image/image_file.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

Status checkImage(const proto::ImageManifest& image, const FileNames& files) {
    const auto corrupt = [](const char* where, std::string message) {
        return Error{ErrorCode::corrupt, where, std::move(message)};
    };
    if (!files.contains("image.h5") || !files.contains("image.digest")) {
        return corrupt("", "image.h5 and image.digest are not among the dataset's files");
    }
    const auto side = [](std::uint32_t pixels) { return pixels >= 1 && pixels <= maxImageSide; };
    const std::uint64_t pixels = std::uint64_t{image.width()} * image.height();
    if (side(image.width()) && side(image.height()) && pixels <= maxImagePixels) return success();
    return corrupt("width",
                   fmt::format("{} x {} pixels are none, or too many", image.width(), image.height()));
}

Status checkImage(const proto::Manifest& manifest, const FileNames& files) {
    MOTE_RETURN_IF_ERROR(checkImage(manifest.image(), files), "image");
    return success();
}

void verifyImage(DatasetVerifier& verifier) {
    verifier.arrayFile(imageName, [](const auto& directory, const auto& manifest) -> Result<ColorImage> {
        MOTE_RETURN_IF_ERROR(readImage(directory, manifest));
        return readColors(directory, manifest);
    });
}

std::string describeImage(const proto::Manifest& manifest) {
    const auto& image = manifest.image();
    auto text = fmt::format("input    {}\nimage    {} x {} pixels, from {} {}{}\n",
                            manifest.request().image().input(), image.width(), image.height(),
                            image.color() ? "colours" : "grey", image.color_space(),
                            image.transparent() ? ", laid on white" : "");
    if (image.invalid() > 0) text += fmt::format("invalid  {} pixels, taken as white\n", image.invalid());
    return text;
}

DatasetSummary summarizeImage(const proto::Manifest& manifest) {
    const std::uint64_t width = manifest.image().width();
    const std::uint64_t height = manifest.image().height();
    return {fmt::format("an image of {} x {} pixels", width, height), {{"width", width}, {"height", height}}};
}

}  // namespace

const DatasetKind imageKind{
    "image", &proto::Manifest::has_image, checkImage, verifyImage, describeImage, summarizeImage};

}  // namespace mote::storage
