// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/selection_edits.h"

#include <gtest/gtest.h>

#include "tests/support/any_selection.h"

namespace mote::client {
namespace {

using test::Random;

test::SelectionShape shape() {
    test::SelectionShape any;
    any.columns = {{"x", -1.0, 1.0}, {"px", -5.0, 5.0}, {"energy", 0.0, 9.0}};
    any.ids = 100;
    any.steps = 4;
    any.depth = 2;
    return any;
}

/// A plain reading of a tree of ranges over one number for each column: what a step is does not matter here.
bool holds(const Selection& selection, double x) {
    bool inside = !selection.nothing;
    for (const auto& range : selection.ranges) inside &= x >= range.min && x <= range.max;
    for (const auto& part : selection.all) inside &= holds(part, x);
    bool any = selection.any.empty();
    for (const auto& part : selection.any) any |= holds(part, x);
    for (const auto& part : selection.negated) inside &= !holds(part, x);
    return inside && any;
}

proto::Selection between(double low, double high, int step) {
    proto::Selection selection;
    auto& range = *selection.add_ranges();
    range.set_column("x");
    range.set_min(low);
    range.set_max(high);
    if (step >= 0) selection.set_step(static_cast<std::uint32_t>(step));
    return selection;
}

TEST(SelectionEdits, GesturesCombineAsSetsDo) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        Random random(seed);
        const auto piece = [&] {
            const double low = random.between(-10.0, 10.0);
            auto made = between(low, low + random.between(0.0, 8.0), static_cast<int>(random.below(3)) - 1);
            if (random.chance(0.2)) made.set_nothing(true);
            return made;
        };
        auto selection = piece();
        for (int gesture = 0; gesture < 6; ++gesture) {
            const auto how = random.oneOf({Combine::both, Combine::either, Combine::without});
            const auto added = piece();
            const auto before = parseSelection(selection).value(), with = parseSelection(added).value();
            selection = combined(selection, how, added);
            const auto parsed = parseSelection(selection);
            ASSERT_TRUE(parsed.ok()) << parsed.error().toString();
            for (double x = -12.0; x < 20.0; x += 0.37) {
                const bool one = holds(before, x), other = holds(with, x);
                const bool expected = how == Combine::both     ? one && other
                                      : how == Combine::either ? one || other
                                                               : one && !other;
                ASSERT_EQ(holds(*parsed, x), expected) << seed << " " << x;
            }
        }
    }
}

TEST(SelectionEdits, TheStepOfEachPartStays) {
    const auto same = combined(between(0, 1, 3), Combine::either, between(2, 3, 3));
    EXPECT_EQ(same.step(), 3U);
    EXPECT_FALSE(same.any(0).has_step());
    const auto other = combined(between(0, 1, 3), Combine::either, between(2, 3, 4));
    EXPECT_FALSE(other.has_step());
    EXPECT_EQ(other.any(0).step(), 3U);
    EXPECT_EQ(other.any(1).step(), 4U);
}

TEST(SelectionEdits, ManyGesturesOfOneKindDoNotNest) {
    for (const auto how : {Combine::both, Combine::either, Combine::without}) {
        auto selection = between(0, 1, 2);
        for (int i = 0; i < 60; ++i) selection = combined(selection, how, between(i, i + 1, 5));
        EXPECT_TRUE(parseSelection(selection).ok());
    }
}

TEST(SelectionEdits, WhatAreShapesIsValidAndIsReadAsItWas) {
    Random random(7);
    for (int i = 0; i < 100; ++i) {
        const auto corners = test::anyPolygon(random, {0.0, 0.0}, {1.0, 1.0}, 20);
        proto::Layer layer;
        const auto camera = fitCamera(plotBounds, random.between(0.3, 3.0));
        const auto lasso = parseSelection(lassoOn(camera, 1.5, layer, corners));
        ASSERT_TRUE(lasso.ok()) << lasso.error().toString();
        EXPECT_EQ(lasso->lasso->points, corners);
        const auto message = polygonIn("x", "px", corners);
        EXPECT_EQ(parseSelection(message).value().polygon->points, corners);
        EXPECT_EQ(cornersOf(message.polygon().points()), corners);
    }
}

TEST(SelectionEdits, NamesAreFollowedAndReplaced) {
    NamedSelectionMessages named;
    for (const char* name : {"a", "b"}) named.Add()->set_name(name);
    *named[0].mutable_selection() = between(0, 1, -1);
    *named[1].mutable_selection()->mutable_negated() = reference("a");
    EXPECT_EQ(namesIn(reference("b"), named), (std::set<std::string>{"a", "b"}));
    EXPECT_EQ(columnsIn(reference("b"), named), std::set<std::string>{"x"});
    EXPECT_EQ(freshName(named, "a"), "a 2");
    EXPECT_EQ(freshName(named, "c"), "c");
    renameIn(*named[1].mutable_selection(), "a", "core");
    EXPECT_EQ(named[1].selection().negated().named(), "core");
    // One that names itself, which no view may have, ends all the same.
    *named[0].mutable_selection() = reference("a");
    EXPECT_EQ(namesIn(reference("a"), named).size(), 1U);
}

TEST(SelectionEdits, AnySelectionIsDescribedInALine) {
    Random random(3);
    for (int i = 0; i < 300; ++i) {
        const auto text = describe(toProto(test::anySelection(random, shape())));
        EXPECT_FALSE(text.empty());
        EXPECT_EQ(text.find('\n'), std::string::npos);
    }
    EXPECT_EQ(describe({}), "all particles");
    proto::Selection nothing;
    nothing.set_nothing(true);
    EXPECT_EQ(describe(nothing), "no particle");
    EXPECT_EQ(describe(combined({}, Combine::without, nothing)), "(all particles, not no particle)");
    EXPECT_EQ(describe(between(0.5, 2, 3)), "x 0.5 to 2 at step 3");
}

}  // namespace
}  // namespace mote::client
