// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/metaimage_volume.h"

#include "preprocess/volume/data_file.h"
#include "preprocess/volume/metaimage_header.h"
#include "preprocess/volume/number_stream.h"
#include "preprocess/volume/stream_volume.h"

namespace mote::prep {
namespace {

/// Turns a file's bytes into its `needed` bytes of numbers: a header skipped, decompressed.
Result<ByteStreamPtr> unwrap(ByteStreamPtr stream, const MetaImageHeader& header, std::uint64_t needed) {
    auto unwrapped = skipHeader(std::move(stream), header.headerSize, needed);
    if (unwrapped && header.compressed)
        unwrapped = inflatedStream(std::move(unwrapped).value(), Inflater::Form::zlib);
    if (!unwrapped || !header.text) return unwrapped;
    return numberStream(std::move(unwrapped).value());
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> openMetaImage(const std::filesystem::path& path) {
    auto file = fileStream(path);
    if (!file) return file.error();
    const auto head = readHead(**file, MetaImageHeader::maxBytes);
    if (!head) return head.error();
    auto header = MetaImageHeader::parse(*head, (*file)->name());
    if (!header) return header.error();
    const std::uint64_t needed = header->shape.voxels() * bytesOf(header->samples.type);
    DataFiles files{path, std::move(file).value(), header->bytes, std::move(header->dataFiles)};
    auto data =
        dataStream(std::move(files), needed, [header = *header](ByteStreamPtr stream, std::uint64_t share) {
            return unwrap(std::move(stream), header, share);
        });
    if (!data) return data.error();
    return StreamVolume::make("metaimage", std::move(header->shape), header->samples,
                              std::move(data).value());
}

}  // namespace mote::prep
