// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureFile: the pictures of a PNG or TIFF file as the numbers that it stores, row by row: no palette is
// looked up, no grey turned round, no bit spread. Files are untrusted: a size is held against the file's
// before memory is taken for it. One owner, one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "preprocess/volume/volume_shape.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// What the head of a picture says.
struct PictureSpec {
    std::uint32_t width = 0, height = 0;
    std::uint32_t samples = 1;  ///< of a pixel, those of opacity among them
    std::uint32_t opacity = 0;  ///< how many of them, the last ones, are that
    bool colour = false;        ///< the first three are red, green and blue
    ScalarType type = ScalarType::u8;
    std::string numbers;                         ///< "uint8", "half": what the file holds, for people
    double pixelWidth = 0.0, pixelHeight = 0.0;  ///< in units of unitLength; 0: not said
    double unitLength = 0.0;                     ///< mm; 0: only their ratio means something
    std::string description;                     ///< text of the program that wrote it
    std::vector<std::string> notes;

    bool isLike(const PictureSpec& other) const {
        return width == other.width && height == other.height && samples == other.samples &&
               colour == other.colour && type == other.type && numbers == other.numbers;
    }
};

class PictureFile {
  public:
    virtual ~PictureFile() = default;
    virtual std::size_t pages() const = 0;
    /// Makes a page the present one. Errors: corrupt, unsupported, resourceExhausted.
    virtual Status enter(std::size_t page) = 0;
    virtual const PictureSpec& spec() const = 0;  ///< of the present page
    /// Its rows from top to bottom, `samples` numbers a pixel. Errors: corrupt, those of `take`.
    using TakeRow = std::function<Status(std::uint32_t row, std::span<const float> pixels)>;
    virtual Status read(const TakeRow& take) = 0;
};

/// `cancelled` is asked while pages are counted. Errors: notFound, permissionDenied, unsupported, corrupt,
/// resourceExhausted, cancelled.
Result<std::unique_ptr<PictureFile>> openTiff(const std::filesystem::path& path,
                                              const std::function<bool()>& cancelled);
Result<std::unique_ptr<PictureFile>> openPng(const std::filesystem::path& path);

/// A small file that says it is huge is refused. `bits` of a sample. Errors: corrupt, resourceExhausted.
Status checkPictureSize(const PictureSpec& spec, unsigned bits, const std::filesystem::path& path,
                        const std::string& where);

}  // namespace mote::prep
