// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rows of points that a step's writer has in memory: the file, what is read of it and its hashes are the same
// as without.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "storage/particles/step_file.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

using storage::StepArray;
using storage::StepFile;

// More than a block of the digest, and no whole number of them.
constexpr std::uint64_t heldPoints = 300'001;

std::string bytesOfFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class HeldRows : public testing::Test {
  protected:
    StepFile make(const std::string& name) {
        storage::StepShape shape;
        shape.nodes = shape.leaves = 1;
        shape.points = heldPoints;
        shape.volumeSize = 2;
        storage::StepAttributes attributes;
        attributes.axes = {"x", "y", "z"};
        attributes.boundsMax = {1.0, 1.0, 1.0};
        auto made = StepFile::create(folder_ / name, shape, attributes);
        EXPECT_TRUE(made.ok());
        return *std::move(made);
    }
    /// In two parts, the second one first.
    void write(const StepFile& file) const {
        constexpr std::uint64_t half = 131'075;
        const std::span<const std::uint64_t> rows(rows_);
        for (const std::uint64_t begin : {half, std::uint64_t{0}}) {
            const auto part = begin == 0 ? rows.first(half) : rows.subspan(half);
            ASSERT_TRUE(
                file.write(StepArray::pointRow, begin * sizeof(std::uint64_t), std::as_bytes(part)).ok());
        }
    }

    void SetUp() override {
        for (std::uint64_t i = 0; i < heldPoints; ++i) rows_.push_back(0xfffffffeU - 7'919 * i);
    }

    TempDir folder_;
    std::vector<std::uint64_t> rows_;
};

TEST_F(HeldRows, fileAndHashesAreTheSame) {
    const auto plain = make("plain.h5");
    write(plain);
    auto holding = make("held.h5");
    std::vector<std::uint32_t> held(heldPoints);
    holding.holdRows(held);
    write(holding);
    EXPECT_EQ(held, (std::vector<std::uint32_t>(rows_.begin(), rows_.end())));
    EXPECT_EQ(bytesOfFile(folder_ / "held.h5"), bytesOfFile(folder_ / "plain.h5"));
    const auto expected = plain.hashes({}), found = holding.hashes({});
    ASSERT_TRUE(expected.ok() && found.ok());
    EXPECT_EQ(found->blocks, expected->blocks);
    EXPECT_EQ(found->whole.xxh3_128, expected->whole.xxh3_128);
}

/// Hashes that a thread makes while the file is written, in an order that is not the file's.
TEST_F(HeldRows, hashesAheadAreTheSame) {
    const auto plain = make("plain.h5");
    write(plain);
    auto ahead = make("ahead.h5");
    std::vector<std::uint32_t> held(heldPoints);
    ahead.holdRows(held);
    std::atomic<int> asked{0};
    ahead.hashAhead([&] { return ++asked < 0; });
    for (std::size_t i = storage::stepArrays.size(); i-- > 0;) {
        const auto which = static_cast<StepArray>(i);
        if (which == StepArray::pointRow) write(ahead);
        ahead.complete(which);
    }
    for (int i = 0; asked < 3 && i < 1000; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_GE(asked, 3);
    const auto expected = plain.hashes({}), found = ahead.hashes({});
    ASSERT_TRUE(expected.ok() && found.ok());
    EXPECT_EQ(found->blocks, expected->blocks);
    EXPECT_EQ(found->whole.xxh3_128, expected->whole.xxh3_128);
}

TEST_F(HeldRows, areReadFromMemory) {
    auto file = make("step.h5");
    write(file);
    std::vector<std::uint32_t> held(heldPoints);
    for (std::uint32_t i = 0; i < heldPoints; ++i) held[i] = i;
    file.holdRows(held);
    std::vector<std::uint64_t> rows(1'000);
    ASSERT_TRUE(
        file.read(StepArray::pointRow, 77 * sizeof(std::uint64_t), std::as_writable_bytes(std::span(rows)))
            .ok());
    for (std::uint64_t i = 0; i < rows.size(); ++i) ASSERT_EQ(rows[i], 77 + i);
}

}  // namespace
}  // namespace mote::test
