// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/nrrd_volume.h"

#include "preprocess/volume/data_file.h"
#include "preprocess/volume/nrrd_header.h"
#include "preprocess/volume/number_stream.h"
#include "preprocess/volume/stream_volume.h"

namespace mote::prep {
namespace {

/// The number of bytes of the first `lines` lines. Errors: corrupt (there are fewer).
Result<std::uint64_t> bytesOfLines(ByteStream& stream, std::uint64_t lines) {
    std::uint64_t bytes = 0;
    MOTE_RETURN_IF_ERROR(stream.seek(0));
    std::string block(4096, '\0');
    while (lines > 0) {
        const auto got = stream.read(block);
        if (!got) return got.error();
        if (*got == 0)
            return Error{ErrorCode::corrupt, stream.name() + ": line skip", "is more than its lines"};
        std::size_t at = 0;
        for (; at < *got && lines > 0; ++at) lines -= block[at] == '\n' ? 1 : 0;
        bytes += at;
    }
    return bytes;
}

/// Turns a file's bytes into its `needed` bytes of numbers: lines skipped, decompressed, bytes skipped.
Result<ByteStreamPtr> unwrap(ByteStreamPtr stream, const NrrdHeader& header, std::uint64_t needed) {
    const auto lines = bytesOfLines(*stream, header.lineSkip);
    if (!lines) return lines.error();
    auto unwrapped = partStream(std::move(stream), *lines);
    if (unwrapped && header.encoding == NrrdHeader::Encoding::gzip) {
        unwrapped = inflatedStream(std::move(unwrapped).value(), Inflater::Form::gzip);
    }
    if (!unwrapped) return unwrapped;
    unwrapped = skipHeader(std::move(unwrapped).value(), header.byteSkip, needed);
    if (!unwrapped || header.encoding != NrrdHeader::Encoding::text) return unwrapped;
    return numberStream(std::move(unwrapped).value());
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path) {
    auto file = fileStream(path);
    if (!file) return file.error();
    const auto head = readHead(**file, NrrdHeader::maxBytes);
    if (!head) return head.error();
    auto header = NrrdHeader::parse(*head, (*file)->name());
    if (!header) return header.error();
    SampleFormat samples;
    const bool text = header->encoding == NrrdHeader::Encoding::text;
    samples.type = text ? ScalarType::f64 : header->shape.type;
    samples.bigEndian = header->bigEndian && !text;
    const std::uint64_t needed = header->shape.voxels() * bytesOf(samples.type);
    DataFiles files{path, std::move(file).value(), header->bytes, std::move(header->dataFiles)};
    auto data =
        dataStream(std::move(files), needed, [header = *header](ByteStreamPtr stream, std::uint64_t share) {
            return unwrap(std::move(stream), header, share);
        });
    if (!data) return data.error();
    return StreamVolume::make("nrrd", std::move(header->shape), samples, std::move(data).value());
}

}  // namespace mote::prep
