// SPDX-License-Identifier: GPL-3.0-or-later
//
// HDF5 files that try to lead out of themselves, or declare what they do not hold.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string species = "/data/1/particles/e";
const std::string trustedPath = species + "/position/x";

class H5Trust : public testing::Test {
  protected:
    /// The error of reading a file that `fill` makes.
    template <class Fill>
    std::string errorWith(Fill fill) {
        {
            H5TestFile file(path());
            file.text("/", "openPMD", "1.1.0");
            file.text("/", "basePath", "/data/%T/");
            file.text("/", "particlesPath", "particles/");
            fill(file);
        }
        return errorOf({path()});
    }
    std::filesystem::path path() const { return folder_ / "run.h5"; }

    TempDir folder_;
};

TEST_F(H5Trust, externalLinksAreNotFollowed) {
    {
        H5TestFile other(folder_ / "other.h5");
        other.data("/x", std::vector<double>{1, 2});
    }
    EXPECT_THAT(errorWith([](H5TestFile& file) {
                    file.group(species + "/position");
                    ASSERT_GE(H5Lcreate_external("other.h5", "/x", file.id(), trustedPath.c_str(),
                                                 H5P_DEFAULT, H5P_DEFAULT),
                              0);
                }),
                AllOf(HasSubstr("unsupported: run.h5:" + trustedPath), HasSubstr("leads out of the file")));
    EXPECT_THAT(
        errorWith([](H5TestFile& file) {  // by way of a soft link
            file.group(species + "/position");
            ASSERT_GE(H5Lcreate_external("other.h5", "/", file.id(), "/out", H5P_DEFAULT, H5P_DEFAULT), 0);
            ASSERT_GE(H5Lcreate_soft("/out/x", file.id(), trustedPath.c_str(), H5P_DEFAULT, H5P_DEFAULT), 0);
        }),
        HasSubstr("unsupported: run.h5:/out: is a link that leads out"));
}

TEST_F(H5Trust, userDefinedLinksAreNotFollowed) {
    H5L_class_t kind{};
    kind.version = H5L_LINK_CLASS_T_VERS;
    kind.id = static_cast<H5L_type_t>(200);
    kind.comment = "test";
    kind.trav_func = [](const char*, hid_t, const void*, size_t, hid_t, hid_t) -> hid_t { return -1; };
    ASSERT_GE(H5Lregister(&kind), 0);
    EXPECT_THAT(errorWith([](H5TestFile& file) {
                    file.group(species);
                    ASSERT_GE(H5Lcreate_ud(file.id(), (species + "/position").c_str(),
                                           static_cast<H5L_type_t>(200), "abc", 3, H5P_DEFAULT, H5P_DEFAULT),
                              0);
                }),
                HasSubstr("leads out of the file"));
    H5Lunregister(static_cast<H5L_type_t>(200));
}

TEST_F(H5Trust, loopsOfSoftLinksEnd) {
    EXPECT_THAT(errorWith([](H5TestFile& file) {
                    file.group(species + "/position");
                    ASSERT_GE(H5Lcreate_soft("/b", file.id(), "/a", H5P_DEFAULT, H5P_DEFAULT), 0);
                    ASSERT_GE(H5Lcreate_soft("/a", file.id(), "/b", H5P_DEFAULT, H5P_DEFAULT), 0);
                    ASSERT_GE(
                        H5Lcreate_soft("/a/x", file.id(), trustedPath.c_str(), H5P_DEFAULT, H5P_DEFAULT), 0);
                }),
                HasSubstr("go round in a circle"));
}

TEST_F(H5Trust, dataInOtherFilesIsNotRead) {
    writeFile(folder_ / "secret", std::string(80, 'x'));
    EXPECT_THAT(errorWith([&](H5TestFile& file) {
                    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
                    ASSERT_GE(H5Pset_external(creation, (folder_ / "secret").c_str(), 0, 80), 0);
                    file.empty(trustedPath, {10}, creation);
                    H5Pclose(creation);
                }),
                HasSubstr("keeps its data in another file"));
    EXPECT_THAT(errorWith([&](H5TestFile& file) {
                    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
                    const hsize_t ten = 10;
                    const hid_t space = H5Screate_simple(1, &ten, nullptr);
                    ASSERT_GE(H5Pset_virtual(creation, space, "other.h5", "/x", space), 0);
                    file.empty(trustedPath, {10}, creation);
                    H5Sclose(space);
                    H5Pclose(creation);
                }),
                HasSubstr("is a virtual dataset"));
}

/// A filter that no HDF5 brings: its plugin must not be looked for.
TEST_F(H5Trust, pluginFiltersAreRefused) {
    H5Z_class2_t filter{};
    filter.version = H5Z_CLASS_T_VERS;
    filter.id = 32768;
    filter.encoder_present = filter.decoder_present = 1;
    filter.name = "made up";
    filter.filter = [](unsigned, size_t, const unsigned*, size_t bytes, size_t*, void**) { return bytes; };
    ASSERT_GE(H5Zregister(&filter), 0);
    const std::string error = errorWith([](H5TestFile& file) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunk = 2;
        H5Pset_chunk(creation, 1, &chunk);
        ASSERT_GE(H5Pset_filter(creation, 32768, 0, 0, nullptr), 0);
        file.empty(trustedPath, {4}, creation);
        H5Pclose(creation);
    });
    EXPECT_THAT(error, AllOf(HasSubstr("unsupported: run.h5:" + trustedPath), HasSubstr("filter 32768"),
                             HasSubstr("h5repack")));
    H5Zunregister(32768);
}

TEST_F(H5Trust, sizesAreNotBelieved) {
    const std::string absurd = errorWith([](H5TestFile& file) {
        // Written late: the file declares 8 PB and holds nothing.
        file.empty(trustedPath, {1'000'000'000'000'000});
    });
    EXPECT_THAT(absurd, AllOf(HasSubstr("corrupt: run.h5:" + trustedPath),
                              HasSubstr("declares 8000000000000000 bytes")));
    const std::string chunked = errorWith([](H5TestFile& file) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunk = 1000;
        H5Pset_chunk(creation, 1, &chunk);
        H5Pset_deflate(creation, 1);
        file.empty(trustedPath, {1'000'000'000'000}, creation);
        H5Pclose(creation);
    });
    EXPECT_THAT(chunked, HasSubstr("nothing was written to it"));
    const std::string bigChunk = errorWith([](H5TestFile& file) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunk = 400'000'000;
        H5Pset_chunk(creation, 1, &chunk);
        H5Pset_deflate(creation, 1);
        file.empty(trustedPath, {400'000'000}, creation);
        H5Pclose(creation);
    });
    EXPECT_THAT(bigChunk, HasSubstr("chunks of 3200000000 bytes; at most 1 GiB is read"));
}

TEST_F(H5Trust, tablesAndTextsAreNoColumns) {
    EXPECT_THAT(errorWith([](H5TestFile& file) {
                    file.empty(trustedPath, {3, 4});
                }),
                HasSubstr("is a table of several dimensions"));
    EXPECT_THAT(errorWith([](H5TestFile& file) {
                    file.group(species + "/position");
                    const hid_t type = H5Tcopy(H5T_C_S1);
                    const hid_t space = H5Screate(H5S_SCALAR);
                    H5Dclose(H5Dcreate2(file.id(), trustedPath.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT,
                                        H5P_DEFAULT));
                    H5Sclose(space);
                    H5Tclose(type);
                }),
                HasSubstr("holds no plain numbers"));
}

TEST_F(H5Trust, aFileThatIsCutShortIsAnError) {
    errorWith([](H5TestFile& file) { file.data(trustedPath, std::vector<double>(1000, 1.0)); });
    const auto size = std::filesystem::file_size(path());
    std::filesystem::resize_file(path(), size - 2000);
    EXPECT_THAT(errorOf({path()}), HasSubstr("corrupt: run.h5"));
}

}  // namespace
}  // namespace mote::test
