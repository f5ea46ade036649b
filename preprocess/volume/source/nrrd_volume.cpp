// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/source/nrrd_volume.h"

#include "preprocess/volume/source/data_file.h"
#include "preprocess/volume/source/nrrd_header.h"
#include "preprocess/volume/source/number_stream.h"
#include "preprocess/volume/source/stream_volume.h"

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

/// From the file's bytes to the numbers: lines skipped, decompressed, bytes skipped.
Result<ByteStreamPtr> unwrap(ByteStreamPtr stream, const NrrdHeader& header, std::uint64_t needed) {
    const auto lines = bytesOfLines(*stream, header.lineSkip);
    if (!lines) return lines.error();
    auto unwrapped = partStream(std::move(stream), *lines);
    if (unwrapped && header.encoding == NrrdHeader::Encoding::gzip) {
        unwrapped = inflatedStream(std::move(unwrapped).value());
    }
    if (!unwrapped) return unwrapped.error();
    const auto size = (*unwrapped)->size();
    if (!header.byteSkip && !size) {
        return Error{ErrorCode::unsupported, (*unwrapped)->name() + ": byte skip",
                     "-1 needs data that are not compressed"};
    }
    const std::uint64_t skip = header.byteSkip ? *header.byteSkip : *size - std::min(*size, needed);
    return partStream(std::move(unwrapped).value(), skip);
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path) {
    auto file = fileStream(path);
    if (!file) return file.error();
    const auto head = readHead(**file, NrrdHeader::maxBytes);
    if (!head) return head.error();
    auto header = NrrdHeader::parse(*head, (*file)->name());
    if (!header) return header.error();
    auto stream = header->dataFile.empty() ? partStream(std::move(file).value(), header->bytes)
                                           : dataFileStream(path, header->dataFile);
    if (!stream) return stream.error();
    const bool text = header->encoding == NrrdHeader::Encoding::text;
    const std::uint64_t needed = header->shape.voxels() * bytesOf(header->shape.type);
    auto data = unwrap(std::move(stream).value(), *header, needed);
    if (!data) return data.error();
    if (text) data = numberStream(std::move(data).value());
    SampleFormat samples;
    samples.type = text ? ScalarType::f64 : header->shape.type;
    samples.bigEndian = header->bigEndian && !text;
    return StreamVolume::make("nrrd", std::move(header->shape), samples, std::move(data).value());
}

}  // namespace mote::prep
