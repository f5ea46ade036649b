// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/dataset_browser.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <set>

#include "tests/support/random.h"
#include "tests/unit/view/unseen_frames.h"

namespace mote::client {
namespace {

using Column = DatasetIndex::Column;

proto::Catalogue catalogueOf(int count) {
    test::Random random(35);
    proto::Catalogue catalogue;
    for (int i = 0; i < count; ++i) {
        auto& entry = *catalogue.add_datasets();
        entry.set_name(fmt::format("data/Run-{:05}", i));
        entry.set_kind(random.chance(0.5) ? "particles" : "hybrid");
        entry.set_steps(static_cast<std::uint32_t>(random.below(50)));
        entry.set_particles(random.below(1000000));
        entry.set_bytes(random.below(1ULL << 40));
        entry.set_prepared_ms(static_cast<std::int64_t>(random.below(1ULL << 41)));
        entry.set_title(random.chance(0.3) ? "Beam halo" : "Quadrupole");
    }
    return catalogue;
}

TEST(DatasetIndex, FindsWhatHoldsAllWordsInTheOrderOfAColumn) {
    const auto catalogue = catalogueOf(1000);
    DatasetIndex index;
    index.setCatalogue(catalogue);
    EXPECT_EQ(index.find("", Column::name, false).size(), 1000U);
    std::set<int> wanted;
    for (int i = 0; i < 1000; ++i) {
        const auto& entry = catalogue.datasets(i);
        if (entry.kind() == "hybrid" && entry.title() == "Beam halo" && i >= 100 && i < 200) wanted.insert(i);
    }
    ASSERT_GT(wanted.size(), 5U);
    const auto found = index.find(" HALO  hybrid run-001", Column::steps, true);
    EXPECT_EQ(std::set<int>(found.begin(), found.end()), wanted);
    for (std::size_t i = 1; i < found.size(); ++i)
        EXPECT_GE(catalogue.datasets(found[i - 1]).steps(), catalogue.datasets(found[i]).steps());
    for (const bool descending : {false, true}) {
        const auto ordered = [&](Column column, auto valueOf) {
            std::vector<std::int64_t> values;
            for (const int place : index.find("run", column, descending))
                values.push_back(static_cast<std::int64_t>(valueOf(catalogue.datasets(place))));
            EXPECT_EQ(values.size(), 1000U);
            if (descending) std::ranges::reverse(values);
            EXPECT_TRUE(std::ranges::is_sorted(values));
        };
        ordered(Column::particles, [](const auto& entry) { return entry.particles(); });
        ordered(Column::size, [](const auto& entry) { return entry.bytes(); });
        ordered(Column::prepared, [](const auto& entry) { return entry.prepared_ms(); });
    }
    EXPECT_TRUE(index.find("halo quadrupole", Column::name, false).empty());
    index.setCatalogue(catalogueOf(3));
    EXPECT_EQ(index.find("", Column::size, false).size(), 3U);
}

/// Vertices of a frame, once all has its place.
int verticesOf(int datasets) {
    const test::UnseenFrames frames(1280.0F, 720.0F);
    int vertices = 0;
    DatasetBrowser browser("/nowhere/connection.json", {});
    browser.setCatalogue(catalogueOf(datasets));
    browser.open(DatasetBrowser::Use::open);
    for (int frame = 0; frame < 4; ++frame) {
        ImGui::NewFrame();
        EXPECT_FALSE(browser.draw({940.0F, 720.0F, 1.0F}).has_value());
        EXPECT_TRUE(browser.isOpen());
        ImGui::Render();
        vertices = ImGui::GetDrawData()->TotalVtxCount;
    }
    return vertices;
}

TEST(DatasetBrowser, DrawsNoMoreThanIsSeenOfTenThousand) {
    const int few = verticesOf(30), many = verticesOf(10000);
    EXPECT_GT(few, 1000);
    EXPECT_LT(std::abs(many - few), 200);  // its sum and the bar that scrolls it
}

}  // namespace
}  // namespace mote::client
