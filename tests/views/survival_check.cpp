// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/survival_check.h"

#include <array>
#include <chrono>
#include <span>
#include <stdexcept>
#include <vector>

#include "storage/hash.h"
#include "storage/storage_error.h"

namespace mote::test {
namespace {

using render::PixelFormat;
using render::Quality;

/// The exact picture, what a session draws in motion (quality_controller.h), and what it may come to.
constexpr std::array<Quality, 5> qualities{
    {{},
     {.resolutionScale = 0.5, .pointFraction = 0.25, .slabs = 24, .samplesPerCell = 1.0},
     {.resolutionScale = 1.0 / 3.0, .pointFraction = 0.03125, .slabs = 24, .samplesPerCell = 0.5},
     {.resolutionScale = 1.0, .pointFraction = 1.0, .slabs = 1, .samplesPerCell = 0.25},
     {.resolutionScale = 0.015625, .pointFraction = 0x1p-20, .slabs = 256, .samplesPerCell = 16.0}}};

/// Empty, or what a device said instead of a picture, whose bytes are added to `pixels`.
std::string drawOrSay(ViewDrawer& drawer, const render::Scene& scene, const Quality& quality,
                      PixelFormat format, std::vector<std::uint8_t>& pixels) {
    try {
        const auto picture = drawer.draw(scene, quality, format);
        pixels.insert(pixels.end(), picture.pixels.begin(), picture.pixels.end());
        return {};
    } catch (const render::DeviceError& failure) {
        return failure.what();
    } catch (const storage::StorageError& failure) {
        return failure.what();
    }
}

}  // namespace

Verdict SurvivalCheck::examine(const proto::View& view) {
    const auto scene = data_.scene(view);
    if (!scene.ok()) throw std::invalid_argument(scene.error().toString());
    Verdict verdict;
    std::vector<std::uint8_t> pixels;
    const auto begin = std::chrono::steady_clock::now();
    for (const auto& quality : qualities) {
        const auto said = drawOrSay(*drawer_, *scene, quality, PixelFormat::srgb8, pixels);
        if (!said.empty()) verdict.text = said;
    }
    drawOrSay(*drawer_, *scene, qualities[1], PixelFormat::linearHalf, pixels);
    verdict.pictures = storage::hash128(std::as_bytes(std::span(pixels)));
    verdict.deviceSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return verdict;
}

}  // namespace mote::test
