// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views beyond the schema's ends are refused with a sentence, and nothing that a message can say does harm.
#include <gtest/gtest.h>

#include "protocol/scene/view.h"
#include "tests/views/out_of_range.h"
#include "tests/views/view_generator.h"

namespace mote::test {
namespace {

constexpr std::uint64_t refusedViews = 3000;

void expectRefused(const Fault& fault) {
    const auto parsed = parseView(fault.view);
    ASSERT_FALSE(parsed.ok()) << fault.what;
    EXPECT_FALSE(parsed.error().message.empty()) << fault.what;
    EXPECT_FALSE(parsed.error().where.empty()) << fault.what;
}

TEST(Refusal, OfWhatIsNoNumber) {
    for (std::uint64_t i = 0; i < refusedViews; ++i) {
        Random random(7, i);
        expectRefused(withoutANumber(random, generatedView(7, i)));
    }
}

TEST(Refusal, OfWhatIsBeyondItsEnds) {
    for (std::uint64_t i = 0; i < refusedViews; ++i) {
        Random random(8, i);
        expectRefused(beyondItsEnds(random, generatedView(8, i)));
    }
}

}  // namespace
}  // namespace mote::test
