// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureKeeper: pictures that are asked for beside those that are shown, for a file or for the clipboard, as
// they are or without their background. No picture says where its background is seen: it is asked for on two,
// and what differs is background. Main thread; owned by the viewer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// Where a picture goes, and how.
struct PictureGoal {
    std::optional<std::filesystem::path> file;  ///< nothing: the clipboard
    bool background = true;
};

class PictureKeeper {
  public:
    using Ask = std::function<std::uint64_t(proto::View, const ViewRequest&)>;  ///< Connection::setView

    explicit PictureKeeper(Ask ask) : ask_(std::move(ask)) {}

    /// Asks for the picture of a view that has a camera and a size. Errors: parseView's.
    Status want(proto::View view, const PictureGoal& goal);
    /// Nothing of a frame that was asked for elsewhere; else what is to be said of it, or an empty text.
    std::optional<std::string> take(const ReceivedFrame& frame);
    /// True if the view was asked for here; there will be no picture.
    bool takeFailure(std::uint64_t view);

  private:
    struct Wanted {
        PictureGoal goal;
        glm::dvec3 background, other;              // linear RGB
        std::map<std::uint64_t, FramePixels> got;  // by view; without pixels until they come
    };
    static std::string keep(const Wanted& wanted);

    Ask ask_;
    std::vector<Wanted> wanted_;
};

/// Another background, linear RGB, on which a view that leaves things to its background looks the same: both
/// are light, or both are dark.
glm::dvec3 otherBackground(const glm::dvec3& background);

/// A picture as it is shown, and in linear light, also on another background.
struct PictureOnTwo {
    const FramePixels &shown, &linear, &again;  ///< SRGB8, and twice LINEAR_HALF
    glm::dvec3 background, other;               ///< linear RGB
};

/// Its pixels without the background, RGBA, 8 bits, sRGB-encoded, not premultiplied. Laid on its own
/// background by a program that mixes encoded values, as they do, it is what is shown, to a step of 255; on
/// white (of a light picture: on black) as if that were its background, as far as one opacity for three
/// colours goes. Sizes and formats agree (our own invariant).
std::vector<std::uint8_t> withoutBackground(const PictureOnTwo& picture);

/// Gives a PNG, written to `file`, to the clipboard by wl-copy (on Wayland) or xclip, which outlive the
/// viewer. Errors: PartFile's, unsupported (neither is installed, or it fails), with what is to be done.
Status copyPng(std::span<const std::uint8_t> png, const std::filesystem::path& file);
/// The same into a file. Errors: PartFile's.
Status writePng(std::span<const std::uint8_t> png, const std::filesystem::path& file);

}  // namespace mote::client
