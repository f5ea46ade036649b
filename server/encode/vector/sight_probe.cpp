// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/sight_probe.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/gtc/packing.hpp>

#include "protocol/base/mote_check.h"

namespace mote::server {
namespace {

constexpr int mostPictures = 8;  // pairs: what lies between the depths of a pixel that they tell is guessed
constexpr float same = 0.002F;   // half a step of 256

glm::vec3 lightAt(const render::Picture& picture, std::uint32_t pixel) {
    std::uint16_t halves[3];
    std::memcpy(halves, picture.pixels.data() + std::size_t{8} * pixel, sizeof(halves));
    return {glm::unpackHalf1x16(halves[0]), glm::unpackHalf1x16(halves[1]), glm::unpackHalf1x16(halves[2])};
}

bool alike(const InFront& a, const InFront& b) {
    const auto differ = glm::abs(a.light - b.light);
    return std::abs(a.through - b.through) <= same && std::max({differ.x, differ.y, differ.z}) <= same;
}

}  // namespace

SightProbe::SightProbe(std::uint32_t width, std::vector<SightPlace> places)
    : width_(width), places_(std::move(places)) {
    std::sort(places_.begin(), places_.end());
    places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
    inFront_.resize(places_.size());
    known_.resize(places_.size());
    choose();
}

std::size_t SightProbe::endOfPixel(std::size_t begin) const {
    std::size_t end = begin + 1;
    while (end < places_.size() && places_[end].pixel == places_[begin].pixel) ++end;
    return end;
}

void SightProbe::learn(const render::Picture& black, const render::Picture& white) {
    MOTE_CHECK(black.format == render::PixelFormat::linearHalf && white.format == black.format);
    for (const auto index : indices_) {
        const auto light = lightAt(black, places_[index].pixel);
        const auto through = lightAt(white, places_[index].pixel) - light;
        inFront_[index] = {light, std::clamp((through.x + through.y + through.z) / 3.0F, 0.0F, 1.0F)};
        known_[index] = 1;
    }
    ++pictures_;
    choose();
}

/// Of places of one pixel, what follows from those that are known: nothing lies before what is nearer than a
/// place before which nothing lies, what is deeper than what is hidden is hidden, and what lies between two
/// places that are alike is as they are. Whether all are known.
bool SightProbe::fill(std::size_t begin, std::size_t end) {
    bool all = true;
    for (std::size_t i = begin; i < end;) {
        if (known_[i]) {
            ++i;
            continue;
        }
        std::size_t after = i;
        while (after < end && !known_[after]) ++after;
        const InFront* const nearer = i > begin ? &inFront_[i - 1] : nullptr;
        const InFront* const deeper = after < end ? &inFront_[after] : nullptr;
        const bool follows = (deeper && deeper->clear()) || (nearer && nearer->hidden()) ||
                             (nearer && deeper && alike(*nearer, *deeper));
        for (std::size_t k = i; follows && k < after; ++k) {
            inFront_[k] = deeper && deeper->clear() ? InFront() : *nearer;
            known_[k] = 1;
        }
        all = all && follows;
        i = after;
    }
    return all;
}

/// Of places of one pixel those that are left become what the deeper known one is, or the nearer.
void SightProbe::guess(std::size_t begin, std::size_t end) {
    for (std::size_t i = end; i-- > begin;) {
        if (known_[i]) continue;
        if (i + 1 < end) inFront_[i] = inFront_[i + 1];
        known_[i] = 1;
    }
}

/// The deepest place of each pixel, then the nearest, then the middle of what is not known.
void SightProbe::choose() {
    wanted_.clear();
    indices_.clear();
    for (std::size_t begin = 0; begin < places_.size();) {
        const auto end = endOfPixel(begin);
        if (pictures_ > 0 && fill(begin, end)) {
            begin = end;
            continue;
        }
        if (pictures_ == mostPictures) {
            guess(begin, end);
        } else {
            std::size_t index = pictures_ == 0 ? end - 1 : begin;
            if (pictures_ > 1) {
                const auto first =
                    static_cast<std::size_t>(std::find(known_.begin() + static_cast<std::ptrdiff_t>(begin),
                                                       known_.begin() + static_cast<std::ptrdiff_t>(end), 0) -
                                             known_.begin());
                std::size_t after = first;
                while (after < end && !known_[after]) ++after;
                index = first + (after - first) / 2;
            }
            indices_.push_back(index);
            wanted_.push_back(places_[index]);
        }
        begin = end;
    }
}

Sight SightProbe::take() {
    return {width_, std::move(places_), std::move(inFront_)};
}

std::uint64_t SightProbe::bytes() const {
    return places_.size() * (sizeof(SightPlace) + sizeof(InFront) + 1) +
           wanted_.size() * (sizeof(SightPlace) + sizeof(std::size_t));
}

}  // namespace mote::server
