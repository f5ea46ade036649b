// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/image_job.h"

#include <fmt/format.h>

#include <string>

#include "preprocess/image/read_picture.h"
#include "preprocess/job.h"
#include "storage/dataset_writer.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// The input as seen from the folder that holds the dataset; nothing else of where it was made.
proto::JobRequest portableRequest(const proto::JobRequest& request, const fs::path& input,
                                  const fs::path& output) {
    proto::JobRequest portable = request;
    portable.clear_output();
    portable.mutable_image()->set_input(portableInput(input, output));
    return portable;
}

proto::Manifest describe(const proto::JobRequest& request, const fs::path& input, const fs::path& output,
                         const Picture& picture) {
    proto::Manifest manifest;
    manifest.set_kind("image");
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    manifest.set_title(request.title().empty() ? input.filename().string() : request.title());
    *manifest.mutable_request() = portableRequest(request, input, output);
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
    MOTE_RETURN_IF_ERROR(storage::writeImage(writer.directory(), picture.luminance));
    const auto cancelled = [&] { return progress.cancelled(); };
    for (const char* suffix : {".h5", ".digest"}) {
        MOTE_RETURN_IF_ERROR(writer.add(std::string(storage::imageName) + suffix, cancelled));
    }
    auto manifest = describe(request, input, output, picture);
    if (cancelled()) return cancelledError();
    MOTE_RETURN_IF_ERROR(writer.publish(manifest));
    manifest.mutable_files()->Assign(writer.files().begin(), writer.files().end());
    progress.report(1.0, "done");
    return manifest;
}

}  // namespace mote::prep
