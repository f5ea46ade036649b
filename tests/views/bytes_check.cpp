// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/bytes_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "tests/support/only_vectors.h"

namespace mote::test {
namespace {

constexpr unsigned mostThreads = 3;

struct Difference {
    int most = 0;        ///< steps of 255
    std::size_t at = 0;  ///< the first such pixel, row by row
};

Difference greatestDifference(const Image& one, const Image& other) {
    if (one.pixels.size() != other.pixels.size()) throw std::logic_error("pictures of different sizes");
    Difference difference;
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
        const int off = std::abs(one.pixels[i] - other.pixels[i]);
        if (off > difference.most) difference = {off, i / 4};
    }
    return difference;
}

/// What must be the same and is not counts as all that can be.
void take(const Image& one, const Image& other, bool mayRound, const std::string& what, Verdict& verdict) {
    const auto [off, at] = greatestDifference(one, other);
    if (off == 0) return;
    verdict.worst = std::max(verdict.worst, mayRound ? off : 255);
    verdict.text += fmt::format("{}: {}/255 at ({}, {}) ", what, off, at % one.width, at / one.width);
}

/// Whether a kind of vectors has a fused multiply-add.
bool isFused(std::int64_t target) {
    return target <= HWY_AVX2;
}

}  // namespace

BytesCheck::BytesCheck() {
    for (unsigned threads = 1; threads <= mostThreads; ++threads)
        drawers_.push_back(drawerOf("cpu", threads));
}

Verdict BytesCheck::examine(const proto::View& view) {
    const auto scene = data_.scene(view);
    if (!scene.ok()) throw std::invalid_argument(scene.error().toString());
    const auto drawn = [&](std::size_t drawer) {
        return imageOf(drawers_[drawer]->draw(*scene, render::Quality::exact()));
    };
    Verdict verdict;
    const Image first = drawn(0);
    for (unsigned threads = 2; threads <= mostThreads; ++threads)
        take(first, drawn(threads - 1), false, fmt::format("{} threads", threads), verdict);
    const auto targets = hwy::SupportedAndGeneratedTargets();  // the best first
    for (const std::int64_t target : targets) {
        const OnlyVectors only(target);
        const bool mayRound = isFused(target) != isFused(targets.front());
        take(first, drawn(0), mayRound, hwy::TargetName(target), verdict);
    }
    return verdict;
}

}  // namespace mote::test
