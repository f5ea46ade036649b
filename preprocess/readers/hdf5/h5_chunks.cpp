// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_chunks.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "preprocess/readers/hdf5/lzf.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t maxChunkBytes = 1ull << 30;
constexpr std::uint64_t deflateRatio = 1040;  // zlib's own limit is 1032:1
constexpr std::size_t maxScratchBytes = 16 << 20;
constexpr std::size_t checksumBytes = 4;
constexpr std::size_t maxFilters = 8;
constexpr H5Z_filter_t lzfFilter = 32000;  // h5py's, as registered with The HDF Group

/// Fletcher's checksum over 16-bit words, most significant byte first, as HDF5 computes it.
std::uint32_t fletcher32(std::span<const std::uint8_t> bytes) {
    std::uint64_t sum1 = 0, sum2 = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
        sum1 += static_cast<std::uint64_t>(bytes[i]) << 8 | (i + 1 < bytes.size() ? bytes[i + 1] : 0u);
        sum1 = (sum1 & 0xffff) + (sum1 >> 16);
        sum2 += sum1;
        sum2 = (sum2 & 0xffff) + (sum2 >> 16);
    }
    return static_cast<std::uint32_t>(sum2 << 16 | sum1);
}

/// Shuffle puts the first bytes of all elements first, then all second bytes, and so on.
void unshuffle(std::size_t elementBytes, std::vector<std::uint8_t>& chunk,
               std::vector<std::uint8_t>& scratch) {
    const std::size_t elements = chunk.size() / elementBytes;
    if (elementBytes < 2 || elements < 2) return;
    scratch = chunk;  // what is left over at the end stays where it is
    for (std::size_t byte = 0; byte < elementBytes; ++byte) {
        const std::uint8_t* from = chunk.data() + byte * elements;
        std::uint8_t* to = scratch.data() + byte;
        for (std::size_t i = 0; i < elements; ++i) to[i * elementBytes] = from[i];
    }
    chunk.swap(scratch);
}

bool checkFletcher(std::vector<std::uint8_t>& chunk) {
    if (chunk.size() < checksumBytes) return false;
    const std::size_t size = chunk.size() - checksumBytes;
    std::uint32_t stored = 0;
    std::memcpy(&stored, chunk.data() + size, checksumBytes);  // little-endian
    const bool same = stored == fletcher32(std::span(chunk).first(size));
    chunk.resize(size);
    return same;
}

struct FreeInflater {
    void operator()(libdeflate_decompressor* inflater) const { libdeflate_free_decompressor(inflater); }
};

/// What a thread needs to decode chunks.
struct Decoder {
    std::unique_ptr<libdeflate_decompressor, FreeInflater> inflater{libdeflate_alloc_decompressor()};
    std::vector<std::uint8_t> scratch;
};

Decoder& decoder() {
    thread_local Decoder own;
    return own;
}

}  // namespace

std::unique_ptr<H5Chunk> H5ChunkStore::take(const std::vector<hsize_t>& first) {
    const std::lock_guard lock(mutex_);
    if (chunks_.empty()) return std::make_unique<H5Chunk>();
    const auto found = std::ranges::find(chunks_, first, [](const auto& chunk) { return chunk->first; });
    // What came back last is the likeliest to be wanted by others.
    if (found == chunks_.end()) std::swap(chunks_.front(), chunks_.back());
    if (found != chunks_.end()) std::swap(*found, chunks_.back());
    auto chunk = std::move(chunks_.back());
    chunks_.pop_back();
    return chunk;
}

void H5ChunkStore::giveBack(std::unique_ptr<H5Chunk> chunk) {
    const std::lock_guard lock(mutex_);
    chunks_.push_back(std::move(chunk));
}

Result<H5Chunks> H5Chunks::open(const H5Object& dataset, std::size_t valueBytes, std::uint64_t fileBytes) {
    const H5Handle creation(H5Dget_create_plist(dataset.handle.get()), H5Pclose);
    const H5Handle type(H5Dget_type(dataset.handle.get()), H5Tclose);
    if (!creation.ok() || !type.ok()) return corrupt(dataset.where, "its layout cannot be read");
    H5Chunks chunks;
    chunks.valueBytes_ = valueBytes;
    chunks.fileBytes_ = fileBytes;
    MOTE_RETURN_IF_ERROR(chunks.readShape(dataset, creation.get()));
    MOTE_RETURN_IF_ERROR(chunks.readFilters(dataset, creation.get()));
    chunks.readFillValue(creation.get(), type.get());
    return chunks;
}

Status H5Chunks::readShape(const H5Object& dataset, hid_t creation) {
    std::array<hsize_t, H5S_MAX_RANK> shape{};
    const int rank = H5Pget_chunk(creation, H5S_MAX_RANK, shape.data());
    if (rank < 1) return corrupt(dataset.where, "has no valid chunk shape");
    shape_.assign(shape.begin(), shape.begin() + rank);
    chunkBytes_ = valueBytes_;
    for (const hsize_t length : shape_) {
        // What is beyond 1 GiB already needs no exact value.
        chunkBytes_ = length == 0                           ? 0
                      : chunkBytes_ > (1ull << 62) / length ? 1ull << 62
                                                            : chunkBytes_ * length;
    }
    if (chunkBytes_ == 0 || chunkBytes_ > maxChunkBytes) {
        return unsupported(dataset.where,
                           "has chunks of " + std::to_string(chunkBytes_) + " bytes; at most 1 GiB is read");
    }
    return success();
}

Status H5Chunks::readFilters(const H5Object& dataset, hid_t creation) {
    const int count = H5Pget_nfilters(creation);
    if (count < 0 || static_cast<std::size_t>(count) > maxFilters) {
        return corrupt(dataset.where, "has no valid list of filters");
    }
    for (int i = 0; i < count; ++i) {
        unsigned flags = 0;
        std::array<unsigned, 8> values{};
        std::size_t valueCount = values.size();
        std::array<char, 64> name{};
        const H5Z_filter_t id = H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &valueCount,
                                               values.data(), name.size() - 1, name.data(), nullptr);
        if (id < 0) return corrupt(dataset.where, "has no valid list of filters");
        const bool known = id == H5Z_FILTER_DEFLATE || id == H5Z_FILTER_SHUFFLE ||
                           id == H5Z_FILTER_FLETCHER32 || id == lzfFilter;
        if (!known) {
            return unsupported(dataset.where, "is compressed by filter " + std::to_string(id) + " '" +
                                                  name.data() +
                                                  "', which is not read; repack it (h5repack -f GZIP=1)");
        }
        // The size of an element is the first parameter of shuffle, set when the dataset is made.
        filters_.push_back({id, valueCount > 0 && values[0] > 0 ? values[0] : valueBytes_});
    }
    return success();
}

void H5Chunks::readFillValue(hid_t creation, hid_t type) {
    fill_.assign(valueBytes_, 0);
    H5D_fill_value_t kind = H5D_FILL_VALUE_UNDEFINED;
    if (H5Pfill_value_defined(creation, &kind) >= 0 && kind == H5D_FILL_VALUE_USER_DEFINED &&
        H5Pget_fill_value(creation, type, fill_.data()) < 0) {
        fill_.assign(valueBytes_, 0);
    }
}

std::uint64_t H5Chunks::greatestRatio() const {
    std::uint64_t ratio = 1;
    for (const Filter& filter : filters_) {
        if (filter.id == H5Z_FILTER_DEFLATE) ratio = std::max(ratio, deflateRatio);
        if (filter.id == lzfFilter) ratio = std::max(ratio, lzfRatio);
    }
    return ratio;
}

Status H5Chunks::load(hid_t dataset, const std::vector<hsize_t>& first, const std::string& where,
                      H5Chunk& chunk) const {
    if (chunk.first == first) return success();
    chunk.first.clear();
    silenceHdf5();
    hsize_t stored = 0;
    haddr_t address = HADDR_UNDEF;
    std::uint32_t skipped = 0;
    if (H5Dget_chunk_info_by_coord(dataset, first.data(), &skipped, &address, &stored) < 0) {
        return corrupt(where, "its list of chunks is damaged");
    }
    if (address == HADDR_UNDEF) {
        fill(chunk.bytes);
        chunk.first = first;
        return success();
    }
    // Deflate adds 5 bytes for each 16 KiB that it cannot make smaller, and a few more.
    if (stored == 0 || stored > fileBytes_ || stored > chunkBytes_ + chunkBytes_ / 1024 + 1024) {
        return corrupt(where, "has a chunk of an impossible size");
    }
    chunk.bytes.resize(stored);
    if (H5Dread_chunk(dataset, H5P_DEFAULT, first.data(), &skipped, chunk.bytes.data()) < 0) {
        return corrupt(where, "a chunk cannot be read: the file is cut short or damaged");
    }
    auto& scratch = decoder().scratch;
    MOTE_RETURN_IF_ERROR(decode(skipped, where, chunk.bytes, scratch));
    if (scratch.capacity() > maxScratchBytes) scratch = {};
    chunk.first = first;
    return success();
}

void H5Chunks::fill(std::vector<std::uint8_t>& chunk) const {
    chunk.resize(chunkBytes_);
    for (std::size_t at = 0; at < chunk.size(); at += valueBytes_) {
        std::copy(fill_.begin(), fill_.end(), chunk.begin() + static_cast<std::ptrdiff_t>(at));
    }
}

/// Undoes the filters, the last one first. Bit i of `skipped`: filter i was left out for this chunk.
Status H5Chunks::decode(std::uint32_t skipped, const std::string& where, std::vector<std::uint8_t>& chunk,
                        std::vector<std::uint8_t>& scratch) const {
    for (std::size_t i = filters_.size(); i-- > 0;) {
        if ((skipped >> i & 1u) != 0) continue;
        switch (filters_[i].id) {
            case H5Z_FILTER_DEFLATE:
                if (!inflateChunk(chunk, scratch)) return corrupt(where, "its compressed data is damaged");
                break;
            case lzfFilter:
                if (!undoLzf(chunk, chunkBytes_ + maxFilters * checksumBytes, scratch))
                    return corrupt(where, "its compressed data (lzf) is damaged");
                chunk.swap(scratch);
                break;
            case H5Z_FILTER_SHUFFLE:
                unshuffle(filters_[i].elementBytes, chunk, scratch);
                break;
            default:
                if (!checkFletcher(chunk)) return corrupt(where, "its checksum does not fit its data");
        }
    }
    if (chunk.size() == chunkBytes_) return success();
    return corrupt(where, "has a chunk that holds " + std::to_string(chunk.size()) + " bytes instead of " +
                              std::to_string(chunkBytes_));
}

bool H5Chunks::inflateChunk(std::vector<std::uint8_t>& chunk, std::vector<std::uint8_t>& scratch) const {
    auto* const inflater = decoder().inflater.get();
    // A checksum may stand behind the values.
    scratch.resize(chunkBytes_ + maxFilters * checksumBytes);
    std::size_t size = 0;
    if (inflater == nullptr ||
        libdeflate_zlib_decompress(inflater, chunk.data(), chunk.size(), scratch.data(), scratch.size(),
                                   &size) != LIBDEFLATE_SUCCESS)
        return false;
    scratch.resize(size);
    chunk.swap(scratch);
    return true;
}

}  // namespace mote::prep
