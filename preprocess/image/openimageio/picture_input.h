// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureInput: a picture file as OpenImageIO reads it. That comes with two hundred other libraries, which
// take .2 s to load, so it is a module of its own (picture_module.cpp), loaded when a picture is read. One
// thread.
#pragma once

#include <string>

namespace mote::prep {

/// What a file says of its picture, as OIIO::ImageSpec has it.
struct PictureSpec {
    int x = 0, y = 0, width = 0, height = 0, depth = 1;       ///< the pixels that there are
    int fullX = 0, fullY = 0, fullWidth = 0, fullHeight = 0;  ///< those that are to be shown
    int channels = 0, alphaChannel = -1;                      ///< -1: there is none
    int tileWidth = 0, tileHeight = 0;                        ///< 0: it lies in rows
    int orientation = 1;                                      ///< as in Exif
    float gamma = 1.0F;
    bool floats = false, deep = false;
    bool straightAlpha = false;  ///< colours are not multiplied by it
    std::string format;          ///< "png"
    std::string colorSpace;      ///< "sRGB"; "" if the file does not say
};

/// Its functions throw what OpenImageIO throws, and else return what is wrong, a part of a sentence; "" if
/// all is well.
class PictureInput {
  public:
    virtual ~PictureInput() = default;
    virtual const PictureSpec& spec() const = 0;
    /// `rows` rows from the `first`, 0 on top of the pixels that there are, all channels of a pixel together;
    /// of tiles whole ones.
    virtual std::string readRows(int first, int rows, float* values) = 0;
};

/// What opens a file of OpenImageIO's format "png"; null, with the reason, where it cannot.
using OpenPicture = PictureInput* (*)(const char* format, const char* path, std::string& why);

/// The module, and what it calls it.
inline constexpr const char* pictureModule = "mote-pictures";
inline constexpr const char* openPictureName = "moteOpenPicture";

}  // namespace mote::prep
