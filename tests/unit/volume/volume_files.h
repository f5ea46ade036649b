// SPDX-License-Identifier: GPL-3.0-or-later
//
// Small volumes as files, and short ways to read them. Values and functions without state.
#pragma once

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "tests/support/temp_dir.h"

namespace mote::test {

/// Numbers as the bytes of a file.
template <class Number>
std::string numberBytes(const std::vector<double>& numbers, bool bigEndian = false) {
    std::string bytes;
    for (const double number : numbers) {
        const auto value = static_cast<Number>(number);
        char one[sizeof(Number)];
        std::memcpy(one, &value, sizeof(Number));
        if (bigEndian) std::reverse(one, one + sizeof(Number));
        bytes.append(one, sizeof(Number));
    }
    return bytes;
}
/// The same, for a type that is known by its name ("i16").
std::string numberBytes(std::string_view type, const std::vector<double>& numbers, bool bigEndian = false);
/// The names of all scalar types.
std::vector<std::string> scalarTypes();

/// 0, 1, 2, ...: all different, so that no two voxels can be exchanged unseen. Fits into every type up to
/// 128.
std::vector<double> countedNumbers(std::size_t count);

void writeFile(const std::filesystem::path& path, std::string_view bytes);

struct WholeVolume {
    std::string format;
    prep::VolumeShape shape;
    bool sequential = false;
    std::vector<float> values;
    std::vector<std::string> notes;
};

/// Reads a volume slice by slice.
Result<WholeVolume> readVolume(const std::filesystem::path& path,
                               const proto::VolumeSourceOptions& options = {});
/// Slices of a volume, in the order that they are asked for; empty if one cannot be read.
std::vector<float> readSlices(const std::filesystem::path& path, const std::vector<std::uint32_t>& slices,
                              const proto::VolumeSourceOptions& options = {});
/// What readSlices() should give, of slices of `size` numbers.
std::vector<double> slicesOf(const std::vector<double>& numbers, std::size_t size,
                             const std::vector<std::uint32_t>& slices);
/// "CODE: WHERE: MESSAGE" of reading it; "" where it is read.
std::string volumeError(const std::filesystem::path& path, const proto::VolumeSourceOptions& options = {});

/// A file of a folder of a test's own, which is read as a volume.
class OneFile {
  public:
    explicit OneFile(const char* name) : name_(name) {}

    Result<WholeVolume> read(const std::string& bytes, const std::string& field = "") const {
        return readVolume(written(bytes), of(field));
    }
    std::string error(const std::string& bytes, const std::string& field = "") const {
        return volumeError(written(bytes), of(field));
    }

  protected:
    TempDir folder_;

  private:
    std::filesystem::path written(const std::string& bytes) const {
        writeFile(folder_ / name_, bytes);
        return folder_ / name_;
    }
    static proto::VolumeSourceOptions of(const std::string& field) {
        proto::VolumeSourceOptions options;
        options.set_field(field);
        return options;
    }

    const char* name_;
};

/// Where the centre of a voxel lies.
glm::dvec3 worldOf(const prep::VolumeShape& shape, double x, double y, double z);

}  // namespace mote::test
