// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/vti_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "preprocess/readers/load_number.h"
#include "preprocess/volume/base64_stream.h"
#include "preprocess/volume/number_stream.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/vti_header.h"
#include "preprocess/volume/zlib_blocks.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t mostBlocks = 1u << 24;  // 512 GiB in the blocks of 32 KiB that VTK writes

/// The sizes that stand before binary values.
class Sizes {
  public:
    Sizes(ByteStream& stream, const VtiHeader& header)
        : stream_(stream), big_(header.bigEndian), width_(header.wideSizes ? 8 : 4) {}

    /// The next `count` of them. Errors: corrupt (the data end before).
    Result<std::vector<std::uint64_t>> next(std::uint64_t count) {
        std::vector<std::uint64_t> sizes;
        std::string bytes;
        // Piece by piece: memory is taken for those that are there, not for those that are declared.
        while (sizes.size() < count) {
            bytes.resize(static_cast<std::size_t>(std::min(count - sizes.size(), piece)) * width_);
            const auto got = stream_.read(bytes);
            if (!got) return got.error();
            if (*got < bytes.size()) {
                return Error{ErrorCode::corrupt, stream_.name(), "ends within its array's sizes"};
            }
            bytes_ += bytes.size();
            for (std::size_t at = 0; at < bytes.size(); at += width_) {
                sizes.push_back(width_ == 8 ? loadNumber<std::uint64_t>(&bytes[at], big_)
                                            : loadNumber<std::uint32_t>(&bytes[at], big_));
            }
        }
        return sizes;
    }

    std::uint64_t bytes() const { return bytes_; }  ///< read so far

  private:
    static constexpr std::uint64_t piece = 1u << 14;

    ByteStream& stream_;
    bool big_;
    std::size_t width_;
    std::uint64_t bytes_ = 0;
};

Error contradiction(const ByteStream& stream, std::uint64_t said, std::uint64_t needed) {
    return {ErrorCode::corrupt, stream.name(),
            fmt::format("its array says {} bytes, and its extent needs {}", said, needed)};
}

/// One size, then the values.
Result<ByteStreamPtr> plainValues(ByteStreamPtr stream, const VtiHeader& header, std::uint64_t needed) {
    Sizes sizes(*stream, header);
    const auto said = sizes.next(1);
    if (!said) return said.error();
    if (said->front() != needed) return contradiction(*stream, said->front(), needed);
    return partStream(std::move(stream), sizes.bytes(), needed);
}

/// How many blocks, their bytes, those of the last one where it is shorter (else 0), the compressed bytes of
/// each; then the blocks.
Result<ByteStreamPtr> compressedValues(ByteStreamPtr stream, const VtiHeader& header, std::uint64_t needed) {
    Sizes sizes(*stream, header);
    const auto counts = sizes.next(3);
    if (!counts) return counts.error();
    const std::uint64_t count = (*counts)[0], full = (*counts)[1], last = (*counts)[2];
    const bool whole = full > 0 && last == needed % full;
    if (!whole || count != needed / full + (last > 0 ? 1 : 0) || count > mostBlocks) {
        return Error{
            ErrorCode::corrupt, stream->name(),
            fmt::format(
                "its array says {} blocks of {} bytes, the last one of {}, and its extent needs {} bytes",
                count, full, last, needed)};
    }
    auto compressed = sizes.next(count);
    if (!compressed) return compressed.error();
    auto data = partStream(std::move(stream), sizes.bytes());
    if (!data) return data.error();
    return zlibBlockStream(std::move(data).value(), {full, needed, std::move(compressed).value()});
}

Result<ByteStreamPtr> values(ByteStreamPtr file, const VtiHeader& header, std::uint64_t needed) {
    auto stream = partStream(std::move(file), header.dataAt);
    if (!stream) return stream.error();
    if (header.encoding == VtiHeader::Encoding::ascii) return numberStream(std::move(stream).value());
    if (header.encoding == VtiHeader::Encoding::base64) stream = base64Stream(std::move(stream).value());
    return header.compressed ? compressedValues(std::move(stream).value(), header, needed)
                             : plainValues(std::move(stream).value(), header, needed);
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> openVti(const std::filesystem::path& path, std::string_view field,
                                              const Progress& progress) {
    auto file = fileStream(path);
    if (!file) return file.error();
    auto header = VtiHeader::parse(**file, field, progress);
    if (!header) return header.error();
    const bool ascii = header->encoding == VtiHeader::Encoding::ascii;
    SampleFormat samples;
    samples.type = ascii ? ScalarType::f64 : header->shape.type;
    samples.bigEndian = header->bigEndian && !ascii;
    const std::uint64_t needed = header->shape.voxels() * bytesOf(samples.type);
    auto data = values(std::move(file).value(), *header, needed);
    if (!data) return data.error();
    return StreamVolume::make("vti", std::move(header->shape), samples, std::move(data).value());
}

}  // namespace mote::prep
