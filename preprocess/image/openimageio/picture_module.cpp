// SPDX-License-Identifier: GPL-3.0-or-later
#include <OpenImageIO/imageio.h>

#include <memory>
#include <utility>

#include "preprocess/image/openimageio/picture_input.h"

namespace mote::prep {
namespace {

PictureSpec specOf(const OIIO::ImageSpec& said, std::string format) {
    return {.x = said.x,
            .y = said.y,
            .width = said.width,
            .height = said.height,
            .depth = said.depth,
            .fullX = said.full_x,
            .fullY = said.full_y,
            .fullWidth = said.full_width,
            .fullHeight = said.full_height,
            .channels = said.nchannels,
            .alphaChannel = said.alpha_channel,
            .tileWidth = said.tile_width,
            .tileHeight = said.tile_height,
            .orientation = said.get_int_attribute("Orientation", 1),
            .gamma = said.get_float_attribute("oiio:Gamma", 1.0F),
            .floats = said.format.is_floating_point(),
            .deep = said.deep,
            .straightAlpha = said.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0,
            .format = std::move(format),
            .colorSpace = std::string(said.get_string_attribute("oiio:ColorSpace"))};
}

class OiioInput final : public PictureInput {
  public:
    OiioInput(std::unique_ptr<OIIO::ImageInput> input, const OIIO::ImageSpec& said)
        : input_(std::move(input)), spec_(specOf(said, input_->format_name())) {}

    const PictureSpec& spec() const override { return spec_; }

    std::string readRows(int first, int rows, float* values) override {
        const int begin = spec_.y + first, end = begin + rows;
        const auto type = OIIO::TypeDesc::FLOAT;
        const bool read = spec_.tileWidth == 0
                              ? input_->read_scanlines(0, 0, begin, end, 0, 0, spec_.channels, type, values)
                              : input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, begin, end, 0, 1, 0,
                                                   spec_.channels, type, values);
        // Its reader of TIFF says that all went well where strips are missing, and keeps the error.
        return read && !input_->has_error() ? "" : "cannot be read: " + input_->geterror();
    }

  private:
    std::unique_ptr<OIIO::ImageInput> input_;
    PictureSpec spec_;
};

}  // namespace

extern "C" PictureInput* moteOpenPicture(const char* format, const char* path, std::string& why) {
    auto input = OIIO::ImageInput::create(format);
    OIIO::ImageSpec said, wishes;
    // Multiplied by alpha while encoded, colours could not be laid on white as light mixes.
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    if (input && input->open(path, said, wishes)) return new OiioInput(std::move(input), said);
    why = "cannot be read: " + (input ? input->geterror() : OIIO::geterror());
    return nullptr;
}

}  // namespace mote::prep
