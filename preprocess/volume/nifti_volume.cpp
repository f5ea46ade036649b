// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/nifti_volume.h"

#include "preprocess/volume/nifti_header.h"
#include "preprocess/volume/stream_volume.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// "brain.hdr" or "brain.hdr.gz": the file "brain.img", or "brain.img.gz", beside it.
Result<ByteStreamPtr> imageBeside(const fs::path& header) {
    fs::path image = header;
    if (image.extension() == ".gz") image.replace_extension();
    image.replace_extension(".img");
    std::error_code code;
    if (fs::exists(image, code)) return fileStream(image);
    image += ".gz";
    if (fs::exists(image, code)) return fileStream(image);
    return Error{ErrorCode::notFound, header.filename().string(), "has no .img file beside it"};
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> openNifti(const fs::path& path) {
    auto file = fileStream(path);
    if (!file) return file.error();
    const auto head = readHead(**file, NiftiHeader::maxBytes);
    if (!head) return head.error();
    auto header = NiftiHeader::parse(*head, (*file)->name());
    if (!header) return header.error();
    if (header->beside) file = imageBeside(path);
    if (!file) return file.error();
    auto data = partStream(std::move(file).value(), header->offset);
    if (!data) return data.error();
    return StreamVolume::make("nifti", std::move(header->shape), header->samples, std::move(data).value());
}

}  // namespace mote::prep
