// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/image_job.h"

#include <fmt/format.h>

#include "preprocess/image/read_picture.h"
#include "preprocess/new_dataset.h"
#include "storage/image/image_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

proto::Manifest describe(const proto::JobRequest& request, const fs::path& input, const fs::path& output,
                         const Picture& picture) {
    auto manifest = beginManifest("image", request, input.filename().string());
    manifest.mutable_request()->mutable_image()->set_input(portableInput(input, output));
    auto& image = *manifest.mutable_image();
    image.set_width(picture.luminance.width);
    image.set_height(picture.luminance.height);
    image.set_color_space(picture.colorSpace);
    image.set_color(picture.color);
    image.set_transparent(picture.transparent);
    image.set_invalid(picture.invalid);
    return manifest;
}

}  // namespace

Result<proto::Manifest> runImageJob(const proto::JobRequest& request, const fs::path& input,
                                    const fs::path& output, const JobResources& resources,
                                    Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto writer, storage::DatasetWriter::create(output));
    MOTE_ASSIGN_OR_RETURN(const auto picture, readPicture(input, resources.memory, progress));
    if (picture.invalid > 0) {
        progress.note(
            fmt::format("{} pixels are not finite numbers and were taken as white", picture.invalid));
    }
    progress.report(0.85, "writing");
    MOTE_RETURN_IF_ERROR(storage::writeImage(writer.directory(), picture.luminance, picture.colors));
    return finishDataset(writer, {storage::imageName}, describe(request, input, output, picture), progress);
}

}  // namespace mote::prep
