// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/png_file.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "protocol/base/mote_check.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view signature = "\x89PNG\r\n\x1a\n"sv;
constexpr std::uint8_t colorType = 2, alphaType = 6;  // R, G, B; and opacity
constexpr std::string_view textName = "Description\0"sv;
// What an sRGB picture says for readers that do not know the chunk of that name (ISO/IEC 15948, 11.3.3.5).
constexpr std::string_view gamma = "\x00\x00\xb1\x8f"sv;
constexpr std::string_view chromaticities =
    "\x00\x00\x7a\x26\x00\x00\x80\x84\x00\x00\xfa\x00\x00\x00\x80\xe8\x00\x00\x75\x30\x00\x00\xea\x60\x00\x00\x3a\x98\x00\x00\x17\x70"sv;
constexpr std::string_view absoluteIntent = "\x03"sv;

// Of libdeflate's 1 to 12. Higher ones up to 6 take up to twice the time for 1 to 6% fewer bytes; 1 is slower
// where a picture is black.
constexpr int packingLevel = 2;
constexpr int samplingLevel = 1;

// Sampled rows lie together: deflate packs a row by what it has seen in those above.
constexpr std::size_t sampledRowsInRun = 8;
constexpr std::size_t sampledRunPeriod = 128;  // rows, from one run to the next

/// In 16 bits and without a branch, as processors do many at once.
std::uint8_t paethOf(std::int16_t left, std::int16_t above, std::int16_t corner) {
    const auto away = [](std::int16_t a, std::int16_t b) {
        return static_cast<std::int16_t>(std::abs(static_cast<std::int16_t>(a - b)));
    };
    const std::int16_t toLeft = away(above, corner), toAbove = away(left, corner);
    const std::int16_t toCorner =
        away(static_cast<std::int16_t>(left + above), static_cast<std::int16_t>(2 * corner));
    const std::int16_t second = toAbove <= toCorner ? above : corner;
    return static_cast<std::uint8_t>((toLeft <= toAbove) & (toLeft <= toCorner) ? left : second);
}

/// What each filter expects of a byte, by its number: nothing, the pixel to the left, the one above, their
/// mean, and Paeth's choice.
template <int filter>
std::uint8_t expected(std::uint8_t left, std::uint8_t above, std::uint8_t corner) {
    if constexpr (filter == 1) return left;
    if constexpr (filter == 2) return above;
    if constexpr (filter == 3) return static_cast<std::uint8_t>((left + above) >> 1);
    if constexpr (filter == 4) return paethOf(left, above, corner);
    return 0;
}
constexpr int filterCount = 5;

struct FreeDeflater {
    void operator()(libdeflate_compressor* deflater) const { libdeflate_free_compressor(deflater); }
    void operator()(libdeflate_decompressor* inflater) const { libdeflate_free_decompressor(inflater); }
};

struct Scratch {
    explicit Scratch(std::size_t wanted)
        : bytes(std::make_unique_for_overwrite<std::uint8_t[]>(wanted)), size(wanted) {}
    std::unique_ptr<std::uint8_t[]> bytes;  // not cleared: they are written before they are read
    std::size_t size;
};

/// The rows of a picture as PNG stores them, one after the other or any.
class RowFilters {
  public:
    explicit RowFilters(const PngSamples& samples)
        : samples_(samples),
          sample_(samples.bits / 8),
          kept_((samples.alpha ? 4 : 3) * sample_),
          size_(kept_ * samples.width),
          row_(margin + size_),
          above_(margin + size_),
          tried_(size_) {}

    /// The bytes of a row, with its filter's number.
    std::size_t stored() const { return 1 + size_; }
    /// As it is.
    void plain(std::size_t y, std::uint8_t* to) const {
        to[0] = 0;
        pack(y, to + 1);
    }
    /// By the filter that leaves least: differences are small where a filter suits, of either sign.
    void filtered(std::size_t y, std::uint8_t* to) {
        moveTo(y);
        std::uint32_t least = UINT32_MAX;
        tryFilter<0>(to, least);
        tryFilter<2>(to, least);
        tryFilter<1>(to, least);
        tryFilter<4>(to, least);
        tryFilter<3>(to, least);
    }

  private:
    static constexpr std::size_t margin = 8;  // the pixel left of the first, 0

    void pack(std::size_t y, std::uint8_t* to) const {
        const std::size_t pixel = samples_.channels * sample_;
        const std::uint8_t* from = samples_.bytes.data() + y * samples_.width * pixel;
        if (pixel == kept_) {
            std::memcpy(to, from, size_);
        } else if (sample_ == 1) {
            // Four bytes at once, of which the next pixel takes the last.
            const std::size_t last = samples_.width - 1;
            for (std::size_t x = 0; x < last; ++x) std::memcpy(to + 3 * x, from + 4 * x, 4);
            std::memcpy(to + 3 * last, from + 4 * last, 3);
        } else {
            for (std::size_t x = 0; x < samples_.width; ++x) std::memcpy(to + 6 * x, from + 8 * x, 6);
        }
    }

    void moveTo(std::size_t y) {
        if (y == 0) {
            std::fill(above_.begin(), above_.end(), std::uint8_t{0});
        } else if (y == next_) {
            std::swap(row_, above_);
        } else {
            pack(y - 1, above_.data() + margin);
        }
        pack(y, row_.data() + margin);
        next_ = y + 1;
    }

    template <int filter>
    void tryFilter(std::uint8_t* to, std::uint32_t& least) {
        if (least == 0) return;
        // Of its own, as bytes that are written could be anything's that is reached by `this`.
        const std::size_t pixel = kept_, size = size_;
        const std::uint8_t *const row = row_.data() + margin, *const above = above_.data() + margin;
        std::uint8_t* const tried = tried_.data();
        for (std::size_t i = 0; i < size; ++i) {
            const auto from = expected<filter>(row[i - pixel], above[i], above[i - pixel]);
            tried[i] = static_cast<std::uint8_t>(row[i] - from);
        }
        std::uint32_t left = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const std::uint8_t difference = tried[i], negative = static_cast<std::uint8_t>(-difference);
            left += difference < negative ? difference : negative;
        }
        if (left >= least) return;
        least = left;
        to[0] = filter;
        std::memcpy(to + 1, tried, size);
    }

    const PngSamples samples_;
    const std::size_t sample_, kept_, size_;  // bytes of a sample, of a pixel's kept ones and of a row
    std::size_t next_ = 0;
    std::vector<std::uint8_t> row_, above_, tried_;
};

/// Returns how many bytes `to` got.
std::size_t packInto(int level, std::span<const std::uint8_t> from, Scratch& to) {
    const std::unique_ptr<libdeflate_compressor, FreeDeflater> deflater(libdeflate_alloc_compressor(level));
    if (!deflater) throw std::bad_alloc();
    const std::size_t bound = libdeflate_zlib_compress_bound(deflater.get(), from.size());
    if (bound > to.size) to = Scratch(bound);
    return libdeflate_zlib_compress(deflater.get(), from.data(), from.size(), to.bytes.get(), to.size);
}

/// Whether rows are packed better by filters than as they are: smooth pictures are, drawings and points on
/// black are not. From a sixteenth of the rows.
bool gainsByFilters(const PngSamples& samples, RowFilters& filters, Scratch& packed) {
    std::vector<std::size_t> rows;
    const std::size_t height = samples.height;
    for (std::size_t y = std::min(sampledRunPeriod, height) / 2; y < height; y += sampledRunPeriod) {
        for (std::size_t i = y; i < std::min(y + sampledRowsInRun, height); ++i) rows.push_back(i);
    }
    const std::size_t stored = filters.stored();
    std::vector<std::uint8_t> sampled(rows.size() * stored);
    for (std::size_t i = 0; i < rows.size(); ++i) filters.plain(rows[i], &sampled[i * stored]);
    const std::size_t plain = packInto(samplingLevel, sampled, packed);
    for (std::size_t i = 0; i < rows.size(); ++i) filters.filtered(rows[i], &sampled[i * stored]);
    return packInto(samplingLevel, sampled, packed) < plain;
}

void putNumber(std::vector<std::uint8_t>& file, std::size_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) file.push_back(static_cast<std::uint8_t>(number >> shift));
}

void putBytes(std::vector<std::uint8_t>& file, std::string_view bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
}

void putChunk(std::vector<std::uint8_t>& file, std::string_view type, std::span<const std::uint8_t> data) {
    putNumber(file, data.size());
    const std::size_t begin = file.size();
    putBytes(file, type);
    file.insert(file.end(), data.begin(), data.end());
    putNumber(file, libdeflate_crc32(0, file.data() + begin, file.size() - begin));
}

std::span<const std::uint8_t> bytesOf(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::uint32_t numberAt(std::span<const std::uint8_t> bytes, std::size_t place) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i) number = number << 8 | bytes[place + i];
    return number;
}

std::string_view textAt(std::span<const std::uint8_t> bytes, std::size_t place, std::size_t size) {
    return {reinterpret_cast<const char*>(bytes.data()) + place, size};
}

Error notWhole() {
    return corrupt("", "is no whole PNG file");
}

struct Chunk {
    std::string_view type;
    std::span<const std::uint8_t> data;
};

/// Takes a chunk from the front of `left`.
Result<Chunk> takeChunk(std::span<const std::uint8_t>& left) {
    constexpr std::size_t around = 12;  // length, type, sum
    if (left.size() < around || numberAt(left, 0) > left.size() - around) return notWhole();
    const std::size_t size = numberAt(left, 0);
    const Chunk chunk{textAt(left, 4, 4), left.subspan(8, size)};
    if (libdeflate_crc32(0, left.data() + 4, 4 + size) != numberAt(left, 8 + size)) return notWhole();
    left = left.subspan(around + size);
    return chunk;
}

Result<PngPicture> pictureOf(std::span<const std::uint8_t> header) {
    if (header.size() != 13) return notWhole();
    PngPicture picture{numberAt(header, 0), numberAt(header, 4), header[8], {}, {}};
    const std::uint64_t width = picture.width, height = picture.height;
    const bool sized = width >= 1 && width <= View::maxSide && height >= 1 && height <= View::maxSide &&
                       width * height <= View::maxPixels;
    if (!sized) return corrupt("", "has a size that no picture has here");
    const bool kind = (picture.bits == 8 || picture.bits == 16) && header[9] == colorType &&
                      header[10] == 0 && header[11] == 0 && header[12] == 0;
    if (!kind) return unsupported("", "is a PNG of another kind than mote-frames writes");
    return picture;
}

/// Rows with their filters' numbers before them become pixels.
Status unfilter(std::span<const std::uint8_t> rows, PngPicture& picture) {
    const std::size_t pixel = std::size_t{3} * (picture.bits / 8), size = picture.width * pixel;
    picture.bytes.resize(size * picture.height);
    const std::vector<std::uint8_t> none(size);
    const std::uint8_t* above = none.data();
    for (std::size_t y = 0; y < picture.height; ++y) {
        const std::uint8_t* const from = &rows[y * (size + 1)];
        std::uint8_t* const to = &picture.bytes[y * size];
        const auto undo = [&]<int filter>() {
            for (std::size_t i = 0; i < size; ++i) {
                const bool first = i < pixel;
                to[i] = static_cast<std::uint8_t>(
                    from[1 + i] +
                    expected<filter>(first ? 0 : to[i - pixel], above[i], first ? 0 : above[i - pixel]));
            }
        };
        if (from[0] == 0) undo.operator()<0>();
        if (from[0] == 1) undo.operator()<1>();
        if (from[0] == 2) undo.operator()<2>();
        if (from[0] == 3) undo.operator()<3>();
        if (from[0] == 4) undo.operator()<4>();
        if (from[0] >= filterCount) return corrupt("", "has a row of an unknown filter");
        above = to;
    }
    return success();
}

Status unpack(std::span<const std::uint8_t> packed, PngPicture& picture) {
    const std::unique_ptr<libdeflate_decompressor, FreeDeflater> inflater(libdeflate_alloc_decompressor());
    if (!inflater) throw std::bad_alloc();
    const Scratch rows(picture.height * (1 + std::size_t{picture.width} * 3 * (picture.bits / 8)));
    std::size_t used = 0;
    const auto result = libdeflate_zlib_decompress_ex(inflater.get(), packed.data(), packed.size(),
                                                      rows.bytes.get(), rows.size, &used, nullptr);
    if (result != LIBDEFLATE_SUCCESS || used != packed.size()) return corrupt("", "has damaged pixels");
    return unfilter({rows.bytes.get(), rows.size}, picture);
}

}  // namespace

std::vector<std::uint8_t> encodePng(const PngSamples& samples, std::string_view description) {
    MOTE_CHECK(samples.width > 0 && samples.height > 0 && (!samples.alpha || samples.channels == 4));
    MOTE_CHECK(samples.bytes.size() ==
               std::size_t{samples.width} * samples.height * samples.channels * (samples.bits / 8));
    RowFilters filters(samples);
    Scratch packed(0);
    const bool filter = gainsByFilters(samples, filters, packed);
    const Scratch rows(filters.stored() * samples.height);
    for (std::size_t y = 0; y < samples.height; ++y) {
        std::uint8_t* const row = rows.bytes.get() + y * filters.stored();
        filter ? filters.filtered(y, row) : filters.plain(y, row);
    }
    const std::size_t size = packInto(packingLevel, {rows.bytes.get(), rows.size}, packed);
    std::vector<std::uint8_t> header, file;
    putNumber(header, samples.width);
    putNumber(header, samples.height);
    header.insert(header.end(),
                  {static_cast<std::uint8_t>(samples.bits), samples.alpha ? alphaType : colorType, 0, 0, 0});
    file.reserve(size + description.size() + 256);
    putBytes(file, signature);
    putChunk(file, "IHDR", header);
    putChunk(file, "gAMA", bytesOf(gamma));
    putChunk(file, "sRGB", bytesOf(absoluteIntent));
    putChunk(file, "cHRM", bytesOf(chromaticities));
    if (!description.empty())
        putChunk(file, "tEXt", bytesOf(std::string(textName) + std::string(description)));
    putChunk(file, "IDAT", {packed.bytes.get(), size});
    putChunk(file, "IEND", {});
    return file;
}

Result<PngPicture> readPng(std::span<const std::uint8_t> file) {
    if (file.size() < signature.size() || textAt(file, 0, signature.size()) != signature) return notWhole();
    auto left = file.subspan(signature.size());
    MOTE_ASSIGN_OR_RETURN(auto chunk, takeChunk(left));
    if (chunk.type != "IHDR") return notWhole();
    MOTE_ASSIGN_OR_RETURN(auto picture, pictureOf(chunk.data));
    std::vector<std::uint8_t> packed;
    while (chunk.type != "IEND") {
        MOTE_ASSIGN_OR_RETURN(chunk, takeChunk(left));
        const auto text = textAt(chunk.data, 0, chunk.data.size());
        if (chunk.type == "IDAT") packed.insert(packed.end(), chunk.data.begin(), chunk.data.end());
        if (chunk.type == "tEXt" && text.starts_with(textName))
            picture.description = text.substr(textName.size());
    }
    if (!left.empty()) return notWhole();
    MOTE_RETURN_IF_ERROR(unpack(packed, picture));
    return picture;
}

}  // namespace mote::client
