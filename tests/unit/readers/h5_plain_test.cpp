// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets whose values lie in the file one behind another, which are read without HDF5, or in small chunks:
// by several threads at once.
#include <gmock/gmock.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::AllOf;
using testing::HasSubstr;

const std::string plainSpecies = "/data/1/particles/e";
const std::string plainX = plainSpecies + "/position/x";
constexpr std::size_t plainRows = 50'001;  // several parts of a read, the last one short

class H5Plain : public SourceTest {
  protected:
    template <class Fill>
    void write(Fill fill, hsize_t userBlock = 0) {
        H5TestFile file(path(), userBlock);
        file.text("/", "openPMD", "1.1.0");
        file.text("/", "particlesPath", "particles/");
        fill(file);
    }
    /// x by HDF5 in its type `type`; returns where its bytes lie.
    haddr_t writeX(hid_t type, hid_t creation = H5P_DEFAULT, hsize_t userBlock = 0) {
        haddr_t offset = HADDR_UNDEF;
        write(
            [&](H5TestFile& file) {
                auto bytes = values();
                ASSERT_GE(H5Tconvert(H5T_NATIVE_DOUBLE, type, plainRows, bytes.data(), nullptr, H5P_DEFAULT),
                          0);
                file.write(plainX, type, bytes.data(), {plainRows}, creation);
                const hid_t dataset = H5Dopen2(file.id(), plainX.c_str(), H5P_DEFAULT);
                offset = H5Dget_offset(dataset);
                H5Dclose(dataset);
            },
            userBlock);
        return offset;
    }
    static std::vector<double> values() {
        std::vector<double> values(plainRows);
        for (std::size_t i = 0; i < plainRows; ++i) values[i] = static_cast<double>(i * i % 127);
        return values;
    }
    /// Several threads read x in parts, each all of it several times.
    static void expectThreadsRead(prep::ParticleSource& source, const std::vector<double>& x) {
        constexpr std::size_t threads = 4, rounds = 5;
        std::vector<std::vector<double>> read(threads);
        std::vector<std::thread> all;
        for (auto& mine : read) {
            all.emplace_back([&mine, &source] {
                prep::ParticleChunk chunk;
                for (std::size_t round = 0; round < rounds; ++round) {
                    mine.clear();
                    for (std::size_t begin = 0; begin < plainRows; begin += 9'999) {
                        const auto size = std::min<std::size_t>(9'999, plainRows - begin);
                        if (!source.read(0, begin, size, {Column::x, Column::weight}, chunk).ok()) return;
                        mine.insert(mine.end(), chunk[Column::x].begin(), chunk[Column::x].end());
                    }
                }
            });
        }
        for (auto& thread : all) thread.join();
        for (const auto& mine : read) EXPECT_EQ(mine, x);
    }
    std::filesystem::path path() const { return folder / "run.h5"; }
};

TEST_F(H5Plain, everyNumberOfThisMachineIsReadAtOnce) {
    for (const hid_t type : {H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I8LE, H5T_STD_I16LE, H5T_STD_I32LE,
                             H5T_STD_I64LE, H5T_STD_U8LE, H5T_STD_U16LE, H5T_STD_U32LE, H5T_STD_U64LE}) {
        writeX(type);
        MOTE_OPEN(source, {path()}, progress);
        EXPECT_TRUE(source->readsAtOnce(0));
        EXPECT_EQ(source->keptBytes(0, 3), 0U);
        EXPECT_EQ(column(*source, 0, Column::x), values());
    }
}

TEST_F(H5Plain, allOthersAreReadByHdf5) {
    const hid_t chunked = H5Pcreate(H5P_DATASET_CREATE), compact = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk = 1000;
    H5Pset_chunk(chunked, 1, &chunk);
    H5Pset_layout(compact, H5D_COMPACT);
    const std::pair<hid_t, hid_t> kinds[] = {{H5T_IEEE_F64BE, H5P_DEFAULT},
                                             {H5T_IEEE_F32BE, H5P_DEFAULT},
                                             {H5T_STD_I32BE, H5P_DEFAULT},
                                             {H5T_IEEE_F64BE, chunked},
                                             {H5T_STD_U8LE, compact}};
    for (const auto& [type, creation] : kinds) {
        writeX(type, creation);
        MOTE_OPEN(source, {path()}, progress);
        EXPECT_FALSE(source->readsAtOnce(0));
        EXPECT_EQ(column(*source, 0, Column::x), values());
    }
    H5Pclose(chunked);
    H5Pclose(compact);
}

/// Chunks that divide neither the rows nor what is read of them together.
TEST_F(H5Plain, chunksAreReadAtOnce) {
    for (const hsize_t chunk : {997, 10'007, 50'001}) {
        for (const hid_t type : {H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_U8LE}) {
            const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
            H5Pset_chunk(creation, 1, &chunk);
            H5Pset_shuffle(creation);
            H5Pset_deflate(creation, 4);
            writeX(type, creation);
            H5Pclose(creation);
            MOTE_OPEN(source, {path()}, progress);
            EXPECT_TRUE(source->readsAtOnce(0));
            EXPECT_EQ(source->keptBytes(0, 3), 3 * chunk * H5Tget_size(type)) << "a chunk for each thread";
            EXPECT_EQ(column(*source, 0, Column::x), values()) << chunk;
            expectThreadsRead(*source, values());
        }
    }
}

TEST_F(H5Plain, chunksOfMoreThanAMebibyteAreNot) {
    constexpr hsize_t rows = 300'000;
    for (const hsize_t chunk : {hsize_t{1} << 17, (hsize_t{1} << 17) + 1}) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        H5Pset_chunk(creation, 1, &chunk);
        H5Pset_deflate(creation, 1);
        const std::vector<double> written(rows, 2.5);
        write(
            [&](H5TestFile& file) { file.write(plainX, H5T_IEEE_F64LE, written.data(), {rows}, creation); });
        H5Pclose(creation);
        MOTE_OPEN(source, {path()}, progress);
        const bool atOnce = chunk == hsize_t{1} << 17;
        EXPECT_EQ(source->readsAtOnce(0), atOnce);
        EXPECT_EQ(source->keptBytes(0, 3), (atOnce ? 3 : 1) * chunk * sizeof(double));
        EXPECT_EQ(column(*source, 0, Column::x), written);
    }
}

TEST_F(H5Plain, offsetsCountFromTheFilesBeginning) {
    const auto offset = writeX(H5T_IEEE_F32LE, H5P_DEFAULT, 4096);
    ASSERT_GE(offset, 4096U);
    MOTE_OPEN(source, {path()}, progress);
    EXPECT_TRUE(source->readsAtOnce(0));
    EXPECT_EQ(column(*source, 0, Column::x), values());
}

TEST_F(H5Plain, idsOfAnySignSurvive) {
    std::vector<std::int64_t> ids(plainRows);
    for (std::size_t i = 0; i < plainRows; ++i) ids[i] = -static_cast<std::int64_t>(i) * 1'000'000'007;
    write([&](H5TestFile& file) {
        file.data(plainX, values());
        file.data(plainSpecies + "/id", ids);
    });
    MOTE_OPEN(source, {path()}, progress);
    EXPECT_TRUE(source->readsAtOnce(0));
    prep::ParticleChunk chunk;
    ASSERT_TRUE(source->read(0, 3, plainRows - 3, {Column::id}, chunk).ok());
    for (std::size_t i = 3; i < plainRows; ++i)
        ASSERT_EQ(chunk.id[i - 3], static_cast<std::uint64_t>(ids[i]));
}

/// HDF5 has rules of its own for fractions and for what does not fit.
TEST_F(H5Plain, idsThatAreNoIntegersAreHdf5s) {
    write([&](H5TestFile& file) {
        file.data(plainX, std::vector<double>{1, 2, 3});
        file.data(plainSpecies + "/id", std::vector<double>{7.9, -1, 1e30});
    });
    MOTE_OPEN(source, {path()}, progress);
    EXPECT_FALSE(source->readsAtOnce(0));
    prep::ParticleChunk chunk;
    ASSERT_TRUE(source->read(0, 0, 3, {Column::id}, chunk).ok());
    EXPECT_EQ(chunk.id, (std::vector<std::uint64_t>{7, 0, std::numeric_limits<std::uint64_t>::max()}));
}

TEST_F(H5Plain, threadsReadTheSame) {
    write([&](H5TestFile& file) {
        file.data(plainX, values());
        file.attribute(plainX, "unitSI", 0.1);
        file.data(plainSpecies + "/positionOffset/x", values());
        file.data(plainSpecies + "/weighting", std::vector<double>(plainRows, 3.0));
    });
    MOTE_OPEN(source, {path()}, progress);
    ASSERT_TRUE(source->readsAtOnce(0));
    const auto x = column(*source, 0, Column::x);
    const auto written = values();
    for (std::size_t i = 0; i < plainRows; ++i) ASSERT_EQ(x[i], written[i] * 0.1 + written[i]);
    expectThreadsRead(*source, x);
}

TEST_F(H5Plain, whatIsCutShortAfterItWasOpenedIsSaid) {
    const auto offset = writeX(H5T_IEEE_F64LE);
    MOTE_OPEN(source, {path()}, progress);
    EXPECT_EQ(column(*source, 0, Column::x), values());
    std::filesystem::resize_file(path(), offset + 40'000 * sizeof(double) + 3);
    prep::ParticleChunk chunk;
    EXPECT_TRUE(source->read(0, 0, 32'768, {Column::x}, chunk).ok());
    const auto status = source->read(0, 0, plainRows, {Column::x}, chunk);
    ASSERT_FALSE(status.ok());
    EXPECT_THAT(status.error().toString(),
                AllOf(HasSubstr("run.h5:" + plainX), HasSubstr("cannot be read: the file is damaged")));
}

/// Offsets that lead beyond the end, or so far that sums of them turn over.
TEST_F(H5Plain, offsetsAreNotBelieved) {
    const auto offset = writeX(H5T_IEEE_F64LE);
    std::string bytes;
    {
        std::ifstream file(path(), std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(file), {});
    }
    const std::string told(reinterpret_cast<const char*>(&offset), sizeof offset);
    const auto at = bytes.find(told);
    ASSERT_NE(at, std::string::npos);
    for (const std::uint64_t lie : {std::uint64_t{bytes.size()} - 8, std::uint64_t{bytes.size()} + 8,
                                    std::uint64_t{1} << 62, ~std::uint64_t{0} - 15}) {
        auto damaged = bytes;
        std::memcpy(damaged.data() + at, &lie, sizeof lie);
        writeFile(path(), damaged);
        EXPECT_THAT(errorOf({path()}), HasSubstr("corrupt: run.h5")) << lie;
    }
}

}  // namespace
}  // namespace mote::test
