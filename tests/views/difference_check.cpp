// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/difference_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"

namespace mote::test {
namespace {

constexpr double mostDoubt = 0.5;  // share of the pixels, in a view that is decided

double secondsSince(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Nothing is seen but background.
bool blank(const Image& image, const glm::dvec3& background) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const auto channel = static_cast<int>(i % 4);
        if (channel == 3) continue;
        const double encoded = std::clamp(linearToSrgb(background[channel]), 0.0, 1.0);
        if (image.pixels[i] != std::lround(255.0 * encoded)) return false;
    }
    return true;
}

/// By more than a view owes.
bool differs(const Image& actual, const Judgement& judgement) {
    Verdict verdict;
    measure(actual, judgement, verdict);
    return verdict.psnr < 45.0;
}

}  // namespace

void measure(const Image& actual, const Judgement& judgement, Verdict& verdict) {
    MOTE_CHECK(actual.pixels.size() == judgement.expected.pixels.size());
    double squares = 0.0, counted = 0.0;
    for (std::size_t i = 0; i < judgement.doubtful.size(); ++i) {
        if (judgement.doubtful[i] != 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            const int off = std::abs(actual.pixels[4 * i + c] - judgement.expected.pixels[4 * i + c]);
            verdict.worst = std::max(verdict.worst, off);
            squares += off * off;
            counted += 1.0;
        }
    }
    if (squares > 0.0) verdict.psnr = 10.0 * std::log10(255.0 * 255.0 * counted / squares);
}

Verdict DifferenceCheck::examine(const proto::View& view) {
    const auto scene = data_.scene(view);
    if (!scene.ok()) throw std::invalid_argument(scene.error().toString());
    Verdict verdict;
    auto begin = std::chrono::steady_clock::now();
    auto judgement = judge(*scene);
    verdict.referenceSeconds = secondsSince(begin);
    begin = std::chrono::steady_clock::now();
    const auto actual = imageOf(drawer_->draw(*scene, render::Quality::exact()));
    verdict.deviceSeconds = secondsSince(begin);
    // What is thin may lie between all samples of the reference and of those that tell its doubts.
    if (differs(actual, judgement)) judgement = judgeClosely(*scene);
    verdict.doubtful = judgement.doubtfulShare();
    verdict.samples = judgement.samples;
    verdict.blank = blank(judgement.expected, scene->view.background);
    if (verdict.doubtful > mostDoubt) verdict.kind = Verdict::Kind::undecided;
    measure(actual, judgement, verdict);
    return verdict;
}

}  // namespace mote::test
