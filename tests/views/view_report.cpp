// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/view_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mote::test {
namespace {

// What all views must come to together: issue "any legal view is right".
constexpr double near = 45.0, nearest = 35.0;  // dB
constexpr double nearShare = 0.99;
constexpr int closeBytes = 1;

/// Of ascending numbers.
double at(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

void ViewReport::add(const std::string& view, const Verdict& verdict) {
    verdicts_.emplace_back(view, verdict);
}

std::size_t ViewReport::count(Verdict::Kind kind) const {
    return static_cast<std::size_t>(std::count_if(
        verdicts_.begin(), verdicts_.end(), [kind](const auto& one) { return one.second.kind == kind; }));
}

std::string ViewReport::nearness() const {
    std::vector<double> psnr;
    double doubtful = 0.0, blank = 0.0;
    for (const auto& [view, verdict] : verdicts_) {
        if (verdict.kind != Verdict::Kind::measured) continue;
        psnr.push_back(verdict.psnr);
        doubtful += verdict.doubtful;
        blank += verdict.blank ? 1.0 : 0.0;
    }
    if (psnr.empty()) return {};
    std::sort(psnr.begin(), psnr.end());
    const auto count = static_cast<double>(psnr.size());
    const auto below = [&](double limit) {
        return std::lower_bound(psnr.begin(), psnr.end(), limit) - psnr.begin();
    };
    return fmt::format(
        "PSNR: least {:.1f}, 1% {:.1f}, 5% {:.1f}, 10% {:.1f}, half {:.1f} dB; below 45 dB: {} ({:.2f}%), "
        "below 40: {}, below 35: {}\nblank: {:.1f}%; pixels in doubt: {:.2f}%\n",
        psnr.front(), at(psnr, 0.01), at(psnr, 0.05), at(psnr, 0.1), at(psnr, 0.5), below(near),
        100.0 * static_cast<double>(below(near)) / count, below(40.0), below(nearest), 100.0 * blank / count,
        100.0 * doubtful / count);
}

std::string ViewReport::steps() const {
    std::map<int, int> histogram;
    for (const auto& [view, verdict] : verdicts_)
        if (verdict.kind == Verdict::Kind::measured) ++histogram[verdict.worst];
    std::string text = "views by greatest difference in steps of 255:";
    for (const auto& [worst, count] : histogram) text += fmt::format(" {}: {},", worst, count);
    return text + '\n';
}

std::string ViewReport::toString() const {
    using enum Verdict::Kind;
    double reference = 0.0, device = 0.0;
    for (const auto& [view, verdict] : verdicts_) {
        reference += verdict.referenceSeconds;
        device += verdict.deviceSeconds;
    }
    std::string text = fmt::format(
        "{} views: {} measured, {} undecided, {} broken, {} dead; reference {:.1f} s, device {:.1f} s\n",
        verdicts_.size(), count(measured), count(undecided), count(broken), count(dead), reference, device);
    if (byNearness()) text += nearness();
    return check_ == "survival" ? text : text + steps();
}

bool ViewReport::good() const {
    using enum Verdict::Kind;
    if (count(broken) + count(dead) > 0) return false;
    std::size_t decided = 0, far = 0;
    for (const auto& [view, verdict] : verdicts_) {
        if (verdict.kind != measured) continue;
        if (check_ == "bytes" && verdict.worst > closeBytes) return false;
        if (!byNearness()) continue;
        ++decided;
        if (verdict.psnr < near) ++far;
        if (verdict.psnr < nearest) return false;
    }
    return static_cast<double>(far) <= (1.0 - nearShare) * static_cast<double>(decided);
}

}  // namespace mote::test
