// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/files/picture_keeper.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <thread>
#include <utility>

#include "client/shared/part_file.h"
#include "client/shared/png_file.h"
#include "client/view/desk.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

/// Values of all half floats, IEEE 754.
const std::vector<float>& halves() {
    static const auto table = [] {
        std::vector<float> values(1 << 16);
        for (std::uint32_t bits = 0; bits < values.size(); ++bits) {
            const int exponent = static_cast<int>(bits >> 10 & 31U);
            const int fraction = static_cast<int>(bits & 1023U);
            const float size = std::ldexp(static_cast<float>(exponent > 0 ? 1024 + fraction : fraction),
                                          std::max(exponent, 1) - 25);
            values[bits] = (bits >> 15) != 0 ? -size : size;
        }
        return values;
    }();
    return table;
}

/// sRGB of linear light from 0 to 1.
double encoded(double light) {
    constexpr std::size_t steps = 1 << 16;  // a 20th of a byte's step where sRGB is steepest
    static const auto table = [] {
        std::vector<float> values(steps + 1);
        for (std::size_t i = 0; i <= steps; ++i)
            values[i] = static_cast<float>(linearToSrgb(static_cast<double>(i) / steps));
        return values;
    }();
    return static_cast<double>(
        table[static_cast<std::size_t>(std::lround(std::clamp(light, 0.0, 1.0) * steps))]);
}

glm::dvec3 encoded(const glm::dvec3& light) {
    return {encoded(light.x), encoded(light.y), encoded(light.z)};
}

glm::dvec3 lightAt(const FramePixels& pixels, std::size_t pixel) {
    std::array<std::uint16_t, 4> bits{};
    std::memcpy(bits.data(), &pixels.bytes[pixel * sizeof bits], sizeof bits);
    return {static_cast<double>(halves()[bits[0]]), static_cast<double>(halves()[bits[1]]),
            static_cast<double>(halves()[bits[2]])};
}

std::uint8_t byteOf(double value) {
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

/// Backgrounds of one picture, and what tells of a pixel how much of them is seen.
class Backgrounds {
  public:
    Backgrounds(const glm::dvec3& own, const glm::dvec3& other)
        : own_(own),
          way_((other - own) / glm::dot(other - own, other - own)),
          far_(isLight(own) ? 0.0 : 1.0),
          ownShown_(glm::round(255.0 * encoded(own)) / 255.0) {}

    /// RGBA, 0 to 1, encoded, of a pixel that is shown so (encoded), and on both so (linear).
    glm::dvec4 pixelOf(const glm::dvec3& shown, const glm::dvec3& on, const glm::dvec3& again) const {
        const double through = std::clamp(glm::dot(again - on, way_), 0.0, 1.0);
        const auto onFar = encoded(on + through * (far_ - own_));
        const auto span = glm::abs(far_ - ownShown_);
        double opacity =
            1.0 - glm::dot(glm::abs(onFar - shown), glm::dvec3(1.0)) / glm::dot(span, glm::dvec3(1.0));
        // Enough for a colour that gives the picture on its own background.
        for (int i = 0; i < 3; ++i) {
            const double away = shown[i] - ownShown_[i];
            const double room = away > 0.0 ? 1.0 - ownShown_[i] : ownShown_[i];
            if (room > 0.0) opacity = std::max(opacity, std::abs(away) / room);
        }
        if (opacity < 0.5 / 255.0) return glm::dvec4(0.0);
        opacity = std::min(std::round(255.0 * opacity) / 255.0, 1.0);
        return {(shown - (1.0 - opacity) * ownShown_) / opacity, opacity};
    }

  private:
    glm::dvec3 own_, way_, far_, ownShown_;
};

/// Waits a moment: both programs stay in the background once they have read all.
bool runOn(const char* program, const std::vector<const char*>& words, const std::filesystem::path& input) {
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (const char* word : words) arguments.push_back(const_cast<char*>(word));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, input.c_str(), O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t process = 0;
    const int failed = ::posix_spawnp(&process, program, &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return false;
    constexpr int looks = 300;
    for (int i = 0; i < looks; ++i) {
        int status = 0;
        if (::waitpid(process, &status, WNOHANG) != 0) return WIFEXITED(status) && WEXITSTATUS(status) == 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;  // it stays in the foreground, and has it
}

}  // namespace

glm::dvec3 otherBackground(const glm::dvec3& background) {
    const double light = luminance(background);
    if (isLight(background)) return glm::dvec3(light > 0.6 ? 0.25 : 1.0);
    return glm::dvec3(light > 0.1 ? 0.0 : 0.2);
}

std::vector<std::uint8_t> withoutBackground(const PictureOnTwo& picture) {
    const auto& [shown, linear, again, background, other] = picture;
    MOTE_CHECK(shown.format == proto::SRGB8 && linear.format == proto::LINEAR_HALF &&
               again.format == proto::LINEAR_HALF);
    MOTE_CHECK(linear.bytes.size() == again.bytes.size() && linear.bytes.size() == 2 * shown.bytes.size());
    const Backgrounds backgrounds(background, other);
    std::vector<std::uint8_t> rgba(shown.bytes.size());
    for (std::size_t at = 0; at < rgba.size(); at += 4) {
        const auto* bytes = &shown.bytes[at];
        const auto pixel = backgrounds.pixelOf(glm::dvec3(bytes[0], bytes[1], bytes[2]) / 255.0,
                                               lightAt(linear, at / 4), lightAt(again, at / 4));
        for (int c = 0; c < 4; ++c) rgba[at + static_cast<std::size_t>(c)] = byteOf(pixel[c]);
    }
    return rgba;
}

Status writePng(std::span<const std::uint8_t> png, const std::filesystem::path& file) {
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(file));
    MOTE_RETURN_IF_ERROR(part->append(png));
    return part->publish();
}

Status copyPng(std::span<const std::uint8_t> png, const std::filesystem::path& file) {
    std::error_code code;
    std::filesystem::create_directories(file.parent_path(), code);
    MOTE_RETURN_IF_ERROR(writePng(png, file));
    const char* wayland = std::getenv("WAYLAND_DISPLAY");
    if (wayland != nullptr && *wayland != '\0' && runOn("wl-copy", {"wl-copy", "--type", "image/png"}, file))
        return success();
    if (runOn("xclip", {"xclip", "-selection", "clipboard", "-target", "image/png", "-in"}, file))
        return success();
    return unsupported(file.string(),
                       "the picture is there, but not in the clipboard: that takes xclip, or wl-copy "
                       "(package wl-clipboard) on Wayland");
}

Status PictureKeeper::want(proto::View view, const PictureGoal& goal) {
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseView(view));
    ViewRequest request;
    request.finalOnly = request.queued = true;
    Wanted wanted{goal, parsed.background, otherBackground(parsed.background), {}};
    wanted.got[ask_(view, request)];
    request.format = proto::LINEAR_HALF;
    for (const auto& background : {wanted.background, wanted.other}) {
        if (goal.background) break;
        const auto shown = linearToSrgb(background);
        view.clear_background();
        for (int i = 0; i < 3; ++i) view.add_background(std::clamp(shown[i], 0.0, 1.0));
        wanted.got[ask_(view, request)];
    }
    wanted_.push_back(std::move(wanted));
    return success();
}

std::optional<std::string> PictureKeeper::take(const ReceivedFrame& frame) {
    const auto id = frame.message.view_id();
    const auto asked = std::ranges::find_if(wanted_, [&](const auto& each) { return each.got.contains(id); });
    if (asked == wanted_.end()) return std::nullopt;
    asked->got[id] = frame.pixels;
    if (std::ranges::any_of(asked->got, [](const auto& each) { return each.second.bytes.empty(); }))
        return "";
    auto said = keep(*asked);
    wanted_.erase(asked);
    return said;
}

bool PictureKeeper::takeFailure(std::uint64_t view) {
    return std::erase_if(wanted_, [&](const auto& each) { return each.got.contains(view); }) > 0;
}

std::string PictureKeeper::keep(const Wanted& wanted) {
    const auto& pixels = wanted.got.begin()->second;  // ids ascend
    PngSamples samples{pixels.width, pixels.height, 8, 4, pixels.bytes};
    std::vector<std::uint8_t> rgba;
    if (!wanted.goal.background) {
        rgba = withoutBackground({pixels, std::next(wanted.got.begin())->second, wanted.got.rbegin()->second,
                                  wanted.background, wanted.other});
        samples.bytes = rgba;
        samples.alpha = true;
    }
    const auto png = encodePng(samples);
    const auto& file = wanted.goal.file;
    const auto kept = file ? writePng(png, *file) : copyPng(png, sessionFolder() / "clipboard.png");
    if (!kept.ok()) return kept.error().toString();
    return fmt::format("{} {} x {} pixels{}", file ? fmt::format("saved {},", file->string()) : "copied,",
                       pixels.width, pixels.height, wanted.goal.background ? "" : ", without background");
}

}  // namespace mote::client
