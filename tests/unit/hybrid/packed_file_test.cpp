// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/packed_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "storage/blocks/mapped_file.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/volume_job_run.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

/// Bytes that compress somewhat.
std::string someBytes(std::size_t size) {
    std::mt19937 random(11);
    std::string bytes(size, '\0');
    for (auto& byte : bytes) byte = static_cast<char>(random() % 7);
    return bytes;
}

void write(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string unpacked(const fs::path& path) {
    const auto source = PackedSource::open(path).value();
    return {std::istreambuf_iterator<char>(source.get()), {}};
}

TEST(PackedFile, HoldsWhatWasPacked) {
    const test::TempDir dir;
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{3'000'001}}) {
        const auto bytes = someBytes(size);
        for (const auto* name : {"a", "b"}) {
            write(dir / name, bytes);
            ASSERT_TRUE(packFile(dir / name).ok());
            EXPECT_FALSE(fs::exists(dir / name));
        }
        EXPECT_EQ(unpacked(dir / "a.zst"), bytes);
        EXPECT_EQ(read(dir / "a.zst"), read(dir / "b.zst"));
        EXPECT_LT(fs::file_size(dir / "a.zst"), size / 2 + 100);
    }
    EXPECT_EQ(packFile(dir / "none").error().code, ErrorCode::notFound);
}

TEST(PackedFile, EndsWhereItWasShortenedOrDamaged) {
    const test::TempDir dir;
    const auto bytes = someBytes(500'000);
    write(dir / "a", bytes);
    ASSERT_TRUE(packFile(dir / "a").ok());
    const auto packed = read(dir / "a.zst");
    for (const double share : {0.0, 0.001, 0.3, 0.999}) {
        const auto at = static_cast<std::size_t>(share * static_cast<double>(packed.size()));
        write(dir / "short.zst", packed.substr(0, at));
        const auto got = unpacked(dir / "short.zst");
        EXPECT_LT(got.size(), bytes.size() + 1);
        EXPECT_EQ(got, bytes.substr(0, got.size()));
        auto damaged = packed;
        damaged[at] = static_cast<char>(~damaged[at]);
        write(dir / "damaged.zst", damaged);
        EXPECT_LE(unpacked(dir / "damaged.zst").size(), std::size_t{1} << 27);
    }
}

TEST(PackedFile, IsUnpackedIntoNoMoreMemoryThanWasAskedFor) {
    const test::TempDir dir;
    const auto bytes = someBytes(3'000'000);
    write(dir / "a", bytes);
    write(dir / "bomb", std::string(std::size_t{1} << 26, '\0'));
    ASSERT_TRUE(packFile(dir / "a").ok() && packFile(dir / "bomb").ok());
    const auto mapped = MappedFile::unpack(dir / "a.zst", bytes.size());
    ASSERT_TRUE(mapped.ok()) << mapped.error().toString();
    EXPECT_TRUE(std::ranges::equal(mapped->bytes(), std::as_bytes(std::span(bytes))));
    EXPECT_FALSE(mapped->damage().has_value());
    EXPECT_EQ(MappedFile::unpack(dir / "a.zst", bytes.size() - 1).error().code, ErrorCode::corrupt);
    EXPECT_LT(fs::file_size(dir / "bomb.zst"), 100'000U);
    EXPECT_EQ(MappedFile::unpack(dir / "bomb.zst", std::size_t{1} << 20).error().code, ErrorCode::corrupt);
    EXPECT_EQ(MappedFile::unpack(dir / "none.zst", 1).error().code, ErrorCode::notFound);
}

TEST(PackedFile, DamageOfAJobsFilesIsFound) {
    const test::TempDir dir;
    auto job = test::jobOf(0.02, 12, "both");
    test::make({test::sample(45, 38, 41)}, job, dir / "a.mote");
    const auto manifest = readManifest(dir / "a.mote").value();
    const auto& entry = manifest.hybrid().steps(0);
    ASSERT_EQ(entry.file(), "step-000000.h5.zst");
    ASSERT_EQ(entry.residual_file(), "residual-000000.vdb.zst");
    for (const auto& name : {entry.file(), entry.residual_file()}) {
        const auto whole = read(dir / "a.mote" / name);
        for (const double share : {0.1, 0.5, 0.9}) {
            auto damaged = whole;
            auto& byte = damaged[static_cast<std::size_t>(share * static_cast<double>(whole.size()))];
            byte = static_cast<char>(~byte);
            write(dir / "a.mote" / name, damaged);
            EXPECT_FALSE(verifyDataset(dir / "a.mote").empty()) << name;
            const bool step = HybridStep::open(dir / "a.mote", manifest, 0).ok();
            EXPECT_EQ(step, name != entry.file());
            const auto residual = readResidual(dir / "a.mote", manifest, 0, [](const ResidualBrick&) {});
            EXPECT_EQ(residual.ok(), name == entry.file());
        }
        write(dir / "a.mote" / name, whole);
    }
    EXPECT_TRUE(verifyDataset(dir / "a.mote").empty());
}

}  // namespace
}  // namespace mote::storage
