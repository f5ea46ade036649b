// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/hybrid/small_hybrid.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <numeric>

#include "storage/dataset_writer.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_encoder.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"

namespace mote::test {

using storage::GridSize;

namespace {

/// In the order of the bricks, of which there are 3 x 2 x 2.
constexpr std::array<GridSize, 5> places{{{0, 0, 0}, {31, 31, 31}, {69, 1, 2}, {32, 39, 5}, {64, 39, 32}}};
constexpr std::array<std::size_t, 5> bricks{0, 0, 2, 4, 11};

}  // namespace

storage::HybridPoints SmallPoints::view() const {
    return {smallErrorGrid, brickBegin, advance, place8, place16, value, error, normal};
}

SmallPoints smallPoints(int bytes) {
    SmallPoints points;
    if (bytes == 5) points.brickBegin.assign(13, 0);
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto& p = places[i];
        if (bytes == 5) {
            for (auto brick = bricks[i] + 1; brick <= 12; ++brick) ++points.brickBegin[brick];
            const auto place = p[0] % 32 + 32 * (p[1] % 32) + 1024 * (p[2] % 32);
            const bool first = i == 0 || bricks[i] != bricks[i - 1];
            points.advance.push_back(static_cast<std::uint16_t>(place - (first ? 0 : before)));
            before = place;
        }
        for (const auto coordinate : p) {
            if (bytes == 6) points.place8.push_back(static_cast<std::uint8_t>(coordinate));
            if (bytes == 9) points.place16.push_back(static_cast<std::uint16_t>(coordinate));
        }
        points.value.push_back(static_cast<std::uint8_t>(50 * i));
        points.error.push_back(static_cast<std::uint8_t>(1 + 60 * i));
        points.normal.push_back(static_cast<std::uint8_t>(i));
    }
    return points;
}

proto::Manifest smallManifest(int pointBytes, int valueBits) {
    proto::Manifest manifest;
    manifest.set_kind("hybrid");
    manifest.set_format(storage::formatVersion);
    auto& hybrid = *manifest.mutable_hybrid();
    for (const auto side : {140U, 80U, 66U}) hybrid.add_source_size(side);
    for (const auto side : {4U, 3U, 2U}) hybrid.add_low_size(side);
    for (const auto side : smallErrorGrid) hybrid.add_error_size(side);
    for (int i = 0; i < 16; ++i) hybrid.add_index_to_world(i % 5 == 0 ? 1.0 : 0.0);
    hybrid.set_value_min(-10.0);
    hybrid.set_value_max(245.0);
    hybrid.set_scalar_type("i16");
    hybrid.set_filter("cubic");
    hybrid.set_value_bits(static_cast<std::uint32_t>(valueBits));
    hybrid.set_point_bytes(static_cast<std::uint32_t>(pointBytes));
    hybrid.set_residual(true);
    auto& step = *hybrid.add_steps();
    step.set_file("step-000000.h5");
    step.set_digest("step-000000.digest");
    step.set_residual_file(storage::residualName(0));
    step.set_value_min(-10.0);
    step.set_value_step(255.0 / (valueBits == 8 ? 255 : 65535));
    step.set_threshold(4.0);
    step.set_error_step(2.0);
    step.set_residual_step(8.0);
    step.set_points(pointBytes > 0 ? places.size() : 0);
    step.set_residual_samples(3);
    step.set_residual_bricks(2);
    for (int bin = 0; bin < storage::valueHistogramBins; ++bin) step.add_histogram(0);
    step.set_histogram(7, 140 * 80 * 66);
    return manifest;
}

void writeBricks(const std::vector<std::pair<GridSize, std::array<std::int32_t, 512>>>& bricks,
                 const storage::ResidualCoding& coding, const std::filesystem::path& path) {
    std::vector<std::unique_ptr<storage::ScratchFile>> scratches;
    auto scratch = storage::ScratchFile::create(path.parent_path() / "scratch");
    ASSERT_TRUE(scratch.ok()) << scratch.error().toString();
    scratches.push_back(*std::move(scratch));
    std::vector<storage::ResidualPart> parts;
    for (const auto& [index, multiples] : bricks) {
        constexpr auto side = storage::residualNodeBricks;
        storage::ResidualEncoder encoder(coding, {index[0] / side, index[1] / side, index[2] / side});
        encoder.add(index, multiples);
        const auto part = encoder.store(*scratches[0]);
        ASSERT_TRUE(part.ok() && part->has_value());
        parts.push_back(**part);
    }
    const auto written = storage::writeResidual(path, coding, parts, scratches);
    ASSERT_TRUE(written.ok()) << written.error().toString();
}

void writeSmallHybrid(const std::filesystem::path& directory, const SmallPoints& points,
                      const proto::Manifest& manifest) {
    auto writer = storage::DatasetWriter::create(directory);
    ASSERT_TRUE(writer.ok()) << writer.error().toString();
    std::vector<std::uint8_t> bytes(24);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{3});
    std::vector<std::uint16_t> words(bytes.begin(), bytes.end());
    const auto view = points.view();
    const auto& hybrid = manifest.hybrid();
    const auto file = storage::HybridStepWriter::create(
        writer->directory(), "step-000000",
        {{4, 3, 2}, hybrid.value_bits(), hybrid.point_bytes(), smallErrorGrid, view.size()});
    ASSERT_TRUE(file.ok()) << file.error().toString();
    storage::LowCodes low = std::span<const std::uint8_t>(bytes);
    if (hybrid.value_bits() == 16) low = std::span<const std::uint16_t>(words);
    ASSERT_TRUE(file->writeLow(low, bytes).ok());
    ASSERT_TRUE(hybrid.point_bytes() == 0 || file->writePoints(0, view).ok());
    ASSERT_TRUE(hybrid.point_bytes() != 5 || file->writeBricks(view.brickBegin).ok());
    ASSERT_TRUE(file->finish().ok());
    std::array<std::int32_t, 512> first{};
    first[0] = -3;
    first[8 * 8 * 7 + 8 * 5 + 2] = 17;
    std::array<std::int32_t, 512> second{};
    second[5] = 1;
    const storage::ResidualCoding coding{smallErrorGrid, 8.0, glm::scale(glm::dmat4(1.0), glm::dvec3(2.0)),
                                         true};
    writeBricks({{{0, 1, 2}, first}, {{8, 0, 4}, second}}, coding,
                writer->directory() / storage::residualName(0));
    for (const auto* name : {"step-000000.h5", "step-000000.digest", "residual-000000.vdb"}) {
        ASSERT_TRUE(writer->add(name).ok());
    }
    const auto published = writer->publish(manifest);
    ASSERT_TRUE(published.ok()) << published.error().toString();
}

}  // namespace mote::test
