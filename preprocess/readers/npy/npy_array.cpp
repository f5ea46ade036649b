// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/npy_array.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string_view>

#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/readers/text/stored_number.h"

namespace mote::prep {
namespace {

constexpr std::size_t blockBytes = 1u << 20;
/// A gap between the last number and the array's end that is worth reading for the checksum.
constexpr std::uint64_t maxTail = 1u << 16;
/// Enough for the header of an array without many fields.
constexpr std::size_t firstBytes = 512;
constexpr std::string_view arrayEnding = ".npy";

/// Integers and floats of 1, 2, 4 or 8 bytes.
StoredNumber storedAs(const NpyField& field) {
    using S = StoredNumber;
    static constexpr S types[3][4] = {{S::int8, S::int16, S::int32, S::int64},
                                      {S::uint8, S::uint16, S::uint32, S::uint64},
                                      {S::uint8, S::float16, S::float32, S::float64}};
    const int power = field.bytes >= 8 ? 3 : field.bytes / 2;
    return types[field.kind == 'i' ? 0 : field.kind == 'f' ? 2 : 1][power];
}

/// Bytes of the whole array; nothing where the product does not fit.
std::optional<std::uint64_t> arrayBytes(const NpyHeader& header) {
    std::uint64_t bytes = header.itemBytes;
    for (const std::uint64_t length : header.shape) {
        if (length != 0 && bytes > std::numeric_limits<std::uint64_t>::max() / length) return std::nullopt;
        bytes *= length;
    }
    return bytes;
}

/// The bytes in which the header lies.
Result<std::vector<char>> headerBytes(const ArrayBytes::Part& part) {
    MOTE_ASSIGN_OR_RETURN(auto bytes, ArrayBytes::open(part));
    std::vector<char> head(static_cast<std::size_t>(std::min<std::uint64_t>(part.bytes, firstBytes)));
    MOTE_RETURN_IF_ERROR(bytes.read(0, head));
    const std::size_t needed = NpyHeader::bytesNeeded(head);
    const auto whole = static_cast<std::size_t>(std::min<std::uint64_t>(part.bytes, needed));
    if (whole <= head.size()) return head;
    const std::size_t before = head.size();
    head.resize(whole);
    MOTE_RETURN_IF_ERROR(bytes.read(before, std::span(head).subspan(before)));
    return head;
}

/// Whether the part is what its checksum says. Error: corrupt.
Status checkWhole(const ArrayBytes::Part& part) {
    MOTE_ASSIGN_OR_RETURN(auto bytes, ArrayBytes::open(part));
    std::vector<char> block;
    for (std::uint64_t done = 0; done < part.bytes; done += block.size()) {
        block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(part.bytes - done, blockBytes)));
        MOTE_RETURN_IF_ERROR(bytes.read(done, block));
    }
    return success();
}

Result<std::vector<NpyArray>> openArchive(ByteSource& archive, const std::filesystem::path& file) {
    MOTE_ASSIGN_OR_RETURN(const auto entries, readZipDirectory(archive));
    std::vector<NpyArray> arrays;
    std::optional<Error> refused;
    for (const ZipEntry& entry : entries) {
        if (!entry.name.ends_with(arrayEnding)) continue;
        std::string name = entry.name.substr(0, entry.name.size() - arrayEnding.size());
        const ArrayBytes::Part part{file,          archive.name() + ": " + name,
                                    entry.offset,  entry.storedBytes,
                                    entry.bytes,   entry.deflated,
                                    entry.checksum};
        auto array = NpyArray::open(std::move(name), part);
        if (array) {
            arrays.push_back(std::move(array).value());
            continue;
        }
        if (array.error().code != ErrorCode::unsupported) return array.error();
        // One that cannot be read is left out, but not one that only damage made so.
        MOTE_RETURN_IF_ERROR(checkWhole(part));
        if (!refused) refused = array.error();
    }
    if (!arrays.empty()) return arrays;
    if (refused) return *refused;
    return unsupported(archive.name(),
                       "is a zip archive without arrays; numpy.savez writes them as NAME.npy");
}

}  // namespace

Result<NpyArray> NpyArray::open(std::string name, ArrayBytes::Part part) {
    MOTE_ASSIGN_OR_RETURN(const auto bytes, headerBytes(part));
    MOTE_ASSIGN_OR_RETURN(auto header, NpyHeader::parse(bytes, part.where));
    const auto declared = arrayBytes(header);
    const std::uint64_t held = part.bytes - std::min(part.bytes, header.dataOffset);
    if (!declared || *declared != held) {
        return corrupt(part.where, "its header declares " +
                                       (declared ? std::to_string(*declared) : "more than 2^64") +
                                       " bytes of data, and it holds " + std::to_string(held));
    }
    return NpyArray{std::move(name), std::move(part), std::move(header)};
}

Result<std::vector<NpyArray>> openNpyArrays(const std::filesystem::path& file) {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(file));
    if (source->compressed()) {
        return unsupported(source->name(), "is a gzipped file; unpack it first (gunzip)");
    }
    std::string begin(4, '\0');
    MOTE_ASSIGN_OR_RETURN(const auto got, source->read(begin));
    if (looksLikeZip(std::string_view(begin).substr(0, got))) return openArchive(*source, file);
    const std::uint64_t bytes = source->fileBytes();
    MOTE_ASSIGN_OR_RETURN(auto array,
                          NpyArray::open("", {file, source->name(), 0, bytes, bytes, false, std::nullopt}));
    std::vector<NpyArray> arrays;
    arrays.push_back(std::move(array));
    return arrays;
}

Result<NpyReader> NpyReader::open(const NpyArray& array, NpyNumbers numbers) {
    MOTE_ASSIGN_OR_RETURN(auto bytes, ArrayBytes::open(array.part));
    return NpyReader(std::move(bytes), std::move(numbers));
}

Status NpyReader::read(std::uint64_t step, std::uint64_t begin, bool last, std::span<double> values) {
    return readAs(step, begin, last, values);
}

Status NpyReader::read(std::uint64_t step, std::uint64_t begin, bool last, std::span<std::uint64_t> values) {
    return readAs(step, begin, last, values);
}

template <class Value>
Status NpyReader::readAs(std::uint64_t step, std::uint64_t begin, bool last, std::span<Value> values) {
    const std::uint64_t stride = numbers_.stride;
    const StoredNumber stored = storedAs(numbers_.type);
    const std::uint64_t first = numbers_.offset + step * numbers_.stepStride + begin * stride;
    const std::size_t rowsPerBlock =
        stride == 0 ? 1 : static_cast<std::size_t>(std::max<std::uint64_t>(1, blockBytes / stride));
    for (std::size_t done = 0; done < values.size();) {
        const std::size_t rows = std::min(rowsPerBlock, values.size() - done);
        block_.resize((rows - 1) * stride + numbers_.type.bytes);
        MOTE_RETURN_IF_ERROR(bytes_.read(first + done * stride, block_));
        for (std::size_t i = 0; i < rows; ++i) {
            values[done + i] = loadStored<Value>(block_.data() + i * stride, stored, numbers_.type.bigEndian);
        }
        if (stride == 0) std::fill(values.begin() + 1, values.end(), values[0]);
        done += stride == 0 ? values.size() : rows;
    }
    return last ? bytes_.finish(maxTail) : success();
}

}  // namespace mote::prep
