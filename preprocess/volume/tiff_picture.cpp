// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <optional>

#include "preprocess/job.h"
#include "preprocess/readers/half_float.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/volume/picture_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr tmsize_t mostAllocation = tmsize_t{1} << 30;
constexpr int pagesPerQuestion = 256;  // is it cancelled?

struct Closer {
    void operator()(TIFF* file) const { TIFFClose(file); }
};
using TiffPtr = std::unique_ptr<TIFF, Closer>;

/// What libtiff has to say goes to the one who asked, not to stderr.
int keepMessage(TIFF*, void* message, const char*, const char* format, va_list words) {
    std::array<char, 256> text{};
    std::vsnprintf(text.data(), text.size(), format, words);
    *static_cast<std::string*>(message) = text.data();
    return 1;
}
int dropMessage(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

TiffPtr openFile(const fs::path& path, std::string& message) {
    TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
    if (options == nullptr) return nullptr;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, mostAllocation);
    TIFFOpenOptionsSetErrorHandlerExtR(options, keepMessage, &message);
    TIFFOpenOptionsSetWarningHandlerExtR(options, dropMessage, nullptr);
    // Not mapped: a file that is cut meanwhile must be no signal.
    TiffPtr file(TIFFOpenExt(path.c_str(), "rm", options));
    TIFFOpenOptionsFree(options);
    return file;
}

/// How a page's samples lie in memory once libtiff has decompressed them.
struct Layout {
    unsigned bits = 8;
    bool half = false;
    bool packed = false;       ///< several samples in a byte, or over its end; each row begins with a byte
    bool separate = false;     ///< each sample has a plane of its own
    std::uint32_t planes = 1;  ///< 1, or where separate the number of samples
};

/// The type of samples of so many bits; nothing where no number is stored so.
std::optional<ScalarType> typeOf(unsigned bits, unsigned format) {
    const bool isSigned = format == SAMPLEFORMAT_INT;
    if (format == SAMPLEFORMAT_IEEEFP) {
        if (bits == 64) return ScalarType::f64;
        return bits == 16 || bits == 32 ? std::optional(ScalarType::f32) : std::nullopt;
    }
    if (format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_INT && format != SAMPLEFORMAT_VOID) {
        return std::nullopt;
    }
    if (isSigned && bits % 8 != 0) return std::nullopt;
    if (bits <= 8) return isSigned ? ScalarType::i8 : ScalarType::u8;
    if (bits <= 16) return isSigned ? ScalarType::i16 : ScalarType::u16;
    if (bits == 32) return isSigned ? ScalarType::i32 : ScalarType::u32;
    if (bits == 64) return isSigned ? ScalarType::i64 : ScalarType::u64;
    return std::nullopt;
}

class TiffPicture : public PictureFile {
  public:
    explicit TiffPicture(const fs::path& path) : path_(path), name_(path.filename().string()) {}

    Status open(const std::function<bool()>& cancelled) {
        file_ = openFile(path_, message_);
        if (!file_) return unreadable();
        std::uint64_t reduced = 0;
        do {
            std::uint32_t kind = 0;
            TIFFGetField(file_.get(), TIFFTAG_SUBFILETYPE, &kind);
            const bool thumbnail = (kind & FILETYPE_REDUCEDIMAGE) != 0;
            if (!thumbnail) offsets_.push_back(TIFFCurrentDirOffset(file_.get()));
            reduced += thumbnail ? 1 : 0;
            if (offsets_.size() % pagesPerQuestion == 0 && cancelled()) return wasCancelled();
        } while (offsets_.size() <= VolumeShape::maxDimension && reduced <= VolumeShape::maxDimension &&
                 TIFFReadDirectory(file_.get()) != 0);
        if (offsets_.empty()) return corrupt(name_, "has no picture but reduced ones");
        message_.clear();
        MOTE_RETURN_IF_ERROR(enter(0));
        if (reduced > 0) {
            spec_.notes.push_back(fmt::format("{}: {} reduced pictures in it were left out", name_, reduced));
        }
        return success();
    }

    std::size_t pages() const override { return offsets_.size(); }
    const PictureSpec& spec() const override { return spec_; }

    Status enter(std::size_t page) override {
        page_ = page;
        if (TIFFSetSubDirectory(file_.get(), offsets_[page]) == 0) return unreadable();
        spec_ = {};
        layout_ = {};
        MOTE_RETURN_IF_ERROR(readSize());
        MOTE_RETURN_IF_ERROR(readColours());
        readExtent();
        const char* text = nullptr;
        if (TIFFGetField(file_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) != 0 && text != nullptr) {
            spec_.description = text;
        }
        return checkPictureSize(spec_, layout_.bits, path_, where());
    }

    Status read(const TakeRow& take) override {
        const auto width = std::size_t{spec_.width} * spec_.samples;
        row_.resize(width);
        return TIFFIsTiled(file_.get()) != 0 ? readTiles(take) : readLines(take);
    }

  private:
    std::string where() const {
        return offsets_.size() > 1 ? fmt::format("{}: page {}", name_, page_ + 1) : name_;
    }
    Status unreadable() const {
        return corrupt(where(), "cannot be read: " + (message_.empty() ? "no reason is known" : message_));
    }
    Error unsupported(std::string message) const {
        return {ErrorCode::unsupported, where(), std::move(message)};
    }

    Status readSize() {
        TIFF* const file = file_.get();
        std::uint16_t samples = 1, bits = 1, format = SAMPLEFORMAT_UINT, planar = PLANARCONFIG_CONTIG;
        if (TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &spec_.width) == 0 ||
            TIFFGetField(file, TIFFTAG_IMAGELENGTH, &spec_.height) == 0) {
            return corrupt(where(), "does not say its size");
        }
        TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &samples);
        TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &bits);
        TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &format);
        TIFFGetFieldDefaulted(file, TIFFTAG_PLANARCONFIG, &planar);
        const auto type = typeOf(bits, format);
        if (!type || samples == 0) {
            return unsupported(fmt::format(
                "holds samples of {} bits, format {}, which are no numbers that are read", bits, format));
        }
        spec_.samples = samples;
        spec_.type = *type;
        layout_.bits = bits;
        layout_.half = format == SAMPLEFORMAT_IEEEFP && bits == 16;
        layout_.packed = bits % 8 != 0;
        layout_.separate = planar == PLANARCONFIG_SEPARATE && samples > 1;
        layout_.planes = layout_.separate ? samples : 1;
        const char* kind = format == SAMPLEFORMAT_IEEEFP ? "float"
                           : format == SAMPLEFORMAT_INT  ? "int"
                                                         : "uint";
        spec_.numbers = fmt::format("{}{}", kind, bits);
        return success();
    }

    Status readColours() {
        TIFF* const file = file_.get();
        std::uint16_t meaning = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE, extra = 0;
        const std::uint16_t* extras = nullptr;
        TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &meaning);
        TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &compression);
        TIFFGetFieldDefaulted(file, TIFFTAG_EXTRASAMPLES, &extra, &extras);
        for (std::uint16_t i = extra; i > 0 && extras[i - 1] != EXTRASAMPLE_UNSPECIFIED; --i) ++spec_.opacity;
        if (spec_.opacity >= spec_.samples) spec_.opacity = 0;
        if (meaning == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG) {
            TIFFSetField(file, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
            meaning = PHOTOMETRIC_RGB;
        }
        const auto colours = spec_.samples - spec_.opacity;
        spec_.colour = meaning == PHOTOMETRIC_RGB && colours >= 3;
        if (meaning == PHOTOMETRIC_PALETTE) {
            spec_.notes.push_back(name_ + ": the numbers of its palette are read, not their colours");
        }
        if (meaning == PHOTOMETRIC_MINISWHITE) {
            spec_.notes.push_back(name_ + ": its numbers are read as they are, though 0 is white");
        }
        std::uint16_t orientation = ORIENTATION_TOPLEFT;
        TIFFGetFieldDefaulted(file, TIFFTAG_ORIENTATION, &orientation);
        if (orientation != ORIENTATION_TOPLEFT) {
            spec_.notes.push_back(
                fmt::format("{}: its orientation {} was not applied: rows and pixels lie as they are stored",
                            name_, orientation));
        }
        if (meaning <= PHOTOMETRIC_PALETTE || meaning == PHOTOMETRIC_MASK || meaning == PHOTOMETRIC_CFA ||
            meaning == PHOTOMETRIC_LOGL) {
            return success();
        }
        return unsupported(
            fmt::format("has colours of kind {} (as CMYK, YCbCr and Lab have), which are not read", meaning));
    }

    /// TIFF 6.0, section 8: pixels per unit.
    void readExtent() {
        float x = 0.0F, y = 0.0F;
        std::uint16_t unit = RESUNIT_INCH;
        if (TIFFGetField(file_.get(), TIFFTAG_XRESOLUTION, &x) == 0 ||
            TIFFGetField(file_.get(), TIFFTAG_YRESOLUTION, &y) == 0) {
            return;
        }
        if (!(x > 0.0F && y > 0.0F && std::isfinite(x) && std::isfinite(y))) return;
        TIFFGetFieldDefaulted(file_.get(), TIFFTAG_RESOLUTIONUNIT, &unit);
        spec_.unitLength = unit == RESUNIT_INCH ? 25.4 : unit == RESUNIT_CENTIMETER ? 10.0 : 0.0;
        spec_.pixelWidth = 1.0 / static_cast<double>(x);
        spec_.pixelHeight = 1.0 / static_cast<double>(y);
    }

    Status readLines(const TakeRow& take) {
        const auto bytes = static_cast<std::size_t>(TIFFScanlineSize64(file_.get()));
        const std::size_t needed = bytesOfRow(layout_.separate ? 1 : spec_.samples);
        if (bytes < needed || bytes > needed + 16) return unreadable();
        block_.resize(bytes);
        for (std::uint32_t y = 0; y < spec_.height; ++y) {
            for (std::uint32_t plane = 0; plane < layout_.planes; ++plane) {
                if (TIFFReadScanline(file_.get(), block_.data(), y, static_cast<std::uint16_t>(plane)) < 0) {
                    return unreadable();
                }
                MOTE_RETURN_IF_ERROR(decode(block_.data(), 0, spec_.width, plane, row_));
            }
            MOTE_RETURN_IF_ERROR(take(y, row_));
        }
        return success();
    }

    std::size_t bytesOfRow(std::uint32_t samples, std::uint32_t width = 0) const {
        return (std::size_t{width == 0 ? spec_.width : width} * samples * layout_.bits + 7) / 8;
    }

    Status readTiles(const TakeRow& take) {
        std::uint32_t width = 0, height = 0;
        TIFFGetField(file_.get(), TIFFTAG_TILEWIDTH, &width);
        TIFFGetField(file_.get(), TIFFTAG_TILELENGTH, &height);
        const std::size_t rowBytes = bytesOfRow(layout_.separate ? 1 : spec_.samples, width);
        const auto bytes = static_cast<std::uint64_t>(TIFFTileSize64(file_.get()));
        if (width == 0 || height == 0 || bytes > static_cast<std::uint64_t>(mostAllocation) ||
            bytes < rowBytes * height) {
            return unreadable();
        }
        block_.resize(static_cast<std::size_t>(bytes));
        const std::size_t pixels = row_.size();
        const auto rows = std::min(height, spec_.height);
        if (pixels * rows * sizeof(float) > static_cast<std::uint64_t>(mostAllocation) * 4)
            return unreadable();
        std::vector<float> strip(pixels * rows);
        for (std::uint32_t y0 = 0; y0 < spec_.height; y0 += height) {
            const auto end = std::min(height, spec_.height - y0);
            for (std::uint32_t x0 = 0; x0 < spec_.width; x0 += width) {
                for (std::uint32_t plane = 0; plane < layout_.planes; ++plane) {
                    if (TIFFReadTile(file_.get(), block_.data(), x0, y0, 0,
                                     static_cast<std::uint16_t>(plane)) < 0) {
                        return unreadable();
                    }
                    for (std::uint32_t y = 0; y < end; ++y) {
                        MOTE_RETURN_IF_ERROR(decode(block_.data() + y * rowBytes, x0,
                                                    std::min(width, spec_.width - x0), plane,
                                                    std::span(strip).subspan(y * pixels, pixels)));
                    }
                }
            }
            for (std::uint32_t y = 0; y < end; ++y) {
                MOTE_RETURN_IF_ERROR(take(y0 + y, std::span(strip).subspan(y * pixels, pixels)));
            }
        }
        return success();
    }

    /// `count` pixels of a row, or of one plane of it, to their places from pixel `x` on.
    Status decode(const char* from, std::uint32_t x, std::uint32_t count, std::uint32_t plane,
                  std::span<float> row) {
        const std::size_t each = layout_.separate ? 1 : spec_.samples;
        decoded_.resize(count * each);
        MOTE_RETURN_IF_ERROR(decodeNumbers(from));
        if (!layout_.separate) {
            std::copy(decoded_.begin(), decoded_.end(), row.begin() + static_cast<std::ptrdiff_t>(x * each));
            return success();
        }
        for (std::size_t i = 0; i < count; ++i) row[(x + i) * spec_.samples + plane] = decoded_[i];
        return success();
    }

    Status decodeNumbers(const char* from) {
        if (layout_.half) {
            for (std::size_t i = 0; i < decoded_.size(); ++i)
                decoded_[i] = loadNumber<HalfFloat>(from + 2 * i, false).value();
            return success();
        }
        if (layout_.packed) {
            unpack(from);
            return success();
        }
        const std::span<const char> bytes(from, decoded_.size() * bytesOf(spec_.type));
        const SampleFormat format{spec_.type, false, 1.0, 0.0};
        if (const auto number = inexactNumber(bytes, format); number && bytesOf(spec_.type) == 8) {
            return unsupported(fmt::format("holds {}, which has more digits than a float keeps", *number));
        }
        decodeSamples(bytes, format, decoded_);
        return success();
    }

    /// The most significant bit comes first.
    void unpack(const char* from) {
        std::size_t at = 0;
        for (float& value : decoded_) {
            unsigned number = 0;
            for (unsigned bit = 0; bit < layout_.bits; ++bit, ++at) {
                const auto byte = static_cast<unsigned char>(from[at / 8]);
                number = number << 1U | (byte >> (7 - at % 8) & 1U);
            }
            value = static_cast<float>(number);
        }
    }

    fs::path path_;
    std::string name_;
    std::string message_;  ///< the last one of libtiff's errors; it has its address
    TiffPtr file_;
    std::vector<std::uint64_t> offsets_;  ///< of the pages in the file
    std::size_t page_ = 0;
    PictureSpec spec_;
    Layout layout_;
    std::vector<char> block_;  ///< a line or tile
    std::vector<float> decoded_, row_;
};

static_assert(std::endian::native == std::endian::little);

}  // namespace

Result<std::unique_ptr<PictureFile>> openTiff(const fs::path& path, const std::function<bool()>& cancelled) {
    auto picture = std::make_unique<TiffPicture>(path);
    MOTE_RETURN_IF_ERROR(picture->open(cancelled));
    return std::unique_ptr<PictureFile>(std::move(picture));
}

}  // namespace mote::prep
