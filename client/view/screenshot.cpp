// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/screenshot.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <unistd.h>

namespace mote::client {

Status writeScreenshot(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                       int height) {
    auto partial = path;
    partial.replace_filename(fmt::format(".{}.{}.png", path.filename().string(), getpid()));
    const auto fail = [&](const std::string& reason) -> Status {
        std::error_code ignored;
        std::filesystem::remove(partial, ignored);
        return Error{ErrorCode::permissionDenied, path.string(), "cannot be written: " + reason};
    };
    auto output = OIIO::ImageOutput::create(partial.string());
    if (!output) return fail(OIIO::geterror());
    const OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    if (!output->open(partial.string(), spec) || !output->write_image(OIIO::TypeDesc::UINT8, rgb.data()) ||
        !output->close()) {
        return fail(output->geterror());
    }
    std::error_code code;
    std::filesystem::rename(partial, path, code);
    return code ? fail(code.message()) : success();
}

}  // namespace mote::client
