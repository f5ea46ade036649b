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

int greatestDifference(const Image& one, const Image& other) {
    if (one.pixels.size() != other.pixels.size()) throw std::logic_error("pictures of different sizes");
    int most = 0;
    for (std::size_t i = 0; i < one.pixels.size(); ++i)
        most = std::max(most, std::abs(one.pixels[i] - other.pixels[i]));
    return most;
}

void take(const Image& one, const Image& other, const std::string& what, Verdict& verdict) {
    const int off = greatestDifference(one, other);
    if (off == 0) return;
    verdict.worst = std::max(verdict.worst, off);
    verdict.text += fmt::format("{}: {}/255 ", what, off);
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
        take(first, drawn(threads - 1), fmt::format("{} threads", threads), verdict);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        const OnlyVectors only(target);
        take(first, drawn(0), hwy::TargetName(target), verdict);
    }
    return verdict;
}

}  // namespace mote::test
