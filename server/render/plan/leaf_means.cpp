// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/leaf_means.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <span>

#include "protocol/base/mote_check.h"

namespace mote::render {
namespace {

ValueCode meanOf(std::span<const ValueCode> codes) {
    std::uint64_t sum = 0, count = 0;
    for (const ValueCode code : codes) {
        if (code == noValue) continue;
        sum += code;
        ++count;
    }
    return count == 0 ? noValue : static_cast<ValueCode>((sum + count / 2) / count);
}

}  // namespace

PointValues leafMeans(const storage::ParticleStep& step, const PointValues& values) {
    constexpr std::size_t block = std::size_t{1} << 12;
    const auto leaves = step.leaves();
    MOTE_CHECK(values.codes.size() == (values.byLeaf ? leaves.size() : step.pointCount()));
    PointValues means{.codes = values.byLeaf ? values.codes : std::vector<ValueCode>(leaves.size()),
                      .byLeaf = true};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), block), [&](const auto& some) {
        if (values.byLeaf) return;
        for (std::size_t i = some.begin(); i < some.end(); ++i)
            means.codes[i] =
                meanOf(std::span(values.codes).subspan(leaves.pointBegin[i], leaves.pointCount[i]));
    });
    means.complete = std::ranges::find(means.codes, noValue) == means.codes.end();
    return means;
}

}  // namespace mote::render
