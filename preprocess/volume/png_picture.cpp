// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cstdio>

#include "preprocess/volume/picture_file.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// libpng ends at errors by a jump to where png_read() began, over no destructor: between lie but C
/// functions.
struct PngReader {
    std::FILE* file = nullptr;
    png_structp png = nullptr;
    png_infop info = nullptr;
    std::string message;

    PngReader() = default;
    ~PngReader() {
        if (png != nullptr) png_destroy_read_struct(&png, &info, nullptr);
        if (file != nullptr) std::fclose(file);
    }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
};

void keepMessage(png_structp png, png_const_charp message) {
    *static_cast<std::string*>(png_get_error_ptr(png)) = message;
    png_longjmp(png, 1);
}
void dropMessage(png_structp, png_const_charp) {}

bool readHead(PngReader& reader) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
    png_init_io(reader.png, reader.file);
    png_read_info(reader.png, reader.info);
    png_set_packing(reader.png);  // numbers of fewer than eight bits, one a byte
    if (png_get_bit_depth(reader.png, reader.info) == 16) png_set_swap(reader.png);
    png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    return true;
}

bool readRow(PngReader& reader, png_bytep row) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
    png_read_row(reader.png, row, nullptr);
    return true;
}

bool readImage(PngReader& reader, png_bytepp rows) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
    png_read_image(reader.png, rows);
    return true;
}

bool readEnd(PngReader& reader) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
    png_read_end(reader.png, nullptr);
    return true;
}

class PngPicture : public PictureFile {
  public:
    explicit PngPicture(const fs::path& path) : path_(path), name_(path.filename().string()) {}

    std::size_t pages() const override { return 1; }
    const PictureSpec& spec() const override { return spec_; }

    /// Begins anew: a picture is read from its first row on.
    Status enter(std::size_t) override {
        reader_ = std::make_unique<PngReader>();
        reader_->file = std::fopen(path_.c_str(), "rb");
        if (reader_->file == nullptr) return notFound(name_, "cannot be opened");
        reader_->png =
            png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader_->message, keepMessage, dropMessage);
        if (reader_->png != nullptr) reader_->info = png_create_info_struct(reader_->png);
        if (reader_->info == nullptr) {
            return Error{ErrorCode::resourceExhausted, name_, "cannot be read: no memory"};
        }
        if (!readHead(*reader_)) return unreadable();
        return readSpec();
    }

    Status read(const TakeRow& take) override {
        const std::size_t numbers = std::size_t{spec_.width} * spec_.samples;
        const std::size_t bytes = numbers * bytesOf(spec_.type);
        if (png_get_rowbytes(reader_->png, reader_->info) != bytes) return unreadable();
        const bool whole = png_get_interlace_type(reader_->png, reader_->info) != PNG_INTERLACE_NONE;
        std::vector<png_byte> block(bytes * (whole ? spec_.height : 1));
        if (whole) {
            std::vector<png_bytep> rows(spec_.height);
            for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = block.data() + y * bytes;
            if (!readImage(*reader_, rows.data())) return unreadable();
        }
        std::vector<float> row(numbers);
        for (std::uint32_t y = 0; y < spec_.height; ++y) {
            if (!whole && !readRow(*reader_, block.data())) return unreadable();
            const auto* const from = block.data() + (whole ? y * bytes : 0);
            decodeSamples({reinterpret_cast<const char*>(from), bytes}, {spec_.type, false, 1.0, 0.0}, row);
            MOTE_RETURN_IF_ERROR(take(y, row));
        }
        return readEnd(*reader_) ? success() : unreadable();
    }

  private:
    Status unreadable() const {
        return corrupt(
            name_, "cannot be read: " + (reader_->message.empty() ? "no reason is known" : reader_->message));
    }

    Status readSpec() {
        auto* const png = reader_->png;
        auto* const info = reader_->info;
        spec_ = {};
        spec_.width = png_get_image_width(png, info);
        spec_.height = png_get_image_height(png, info);
        const int colour = png_get_color_type(png, info);
        const unsigned bits = png_get_bit_depth(png, info);
        spec_.samples = png_get_channels(png, info);
        spec_.opacity = (colour & PNG_COLOR_MASK_ALPHA) != 0 ? 1 : 0;
        spec_.colour = colour == PNG_COLOR_TYPE_RGB || colour == PNG_COLOR_TYPE_RGB_ALPHA;
        spec_.type = bits == 16 ? ScalarType::u16 : ScalarType::u8;
        spec_.numbers = bits == 16 ? "uint16" : "uint8";
        if (colour == PNG_COLOR_TYPE_PALETTE) {
            spec_.notes.push_back(name_ + ": the numbers of its palette are read, not their colours");
        }
        const auto x = png_get_x_pixels_per_meter(png, info), y = png_get_y_pixels_per_meter(png, info);
        if (x > 0 && y > 0) {
            spec_.pixelWidth = 1.0 / x;
            spec_.pixelHeight = 1.0 / y;
            spec_.unitLength = 1000.0;
        }
        return checkPictureSize(spec_, bits, path_, name_);
    }

    fs::path path_;
    std::string name_;
    std::unique_ptr<PngReader> reader_;
    PictureSpec spec_;
};

}  // namespace

Result<std::unique_ptr<PictureFile>> openPng(const fs::path& path) {
    auto picture = std::make_unique<PngPicture>(path);
    MOTE_RETURN_IF_ERROR(picture->enter(0));
    return std::unique_ptr<PictureFile>(std::move(picture));
}

}  // namespace mote::prep
