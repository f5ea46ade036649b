// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/volume/volume_files.h"

#include <fstream>
#include <numeric>
#include <span>

#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {

std::string numberBytes(std::string_view type, const std::vector<double>& numbers, bool bigEndian) {
    if (type == "u8") return numberBytes<std::uint8_t>(numbers, bigEndian);
    if (type == "i8") return numberBytes<std::int8_t>(numbers, bigEndian);
    if (type == "u16") return numberBytes<std::uint16_t>(numbers, bigEndian);
    if (type == "i16") return numberBytes<std::int16_t>(numbers, bigEndian);
    if (type == "u32") return numberBytes<std::uint32_t>(numbers, bigEndian);
    if (type == "i32") return numberBytes<std::int32_t>(numbers, bigEndian);
    if (type == "f32") return numberBytes<float>(numbers, bigEndian);
    return numberBytes<double>(numbers, bigEndian);
}

std::vector<std::string> scalarTypes() {
    return {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"};
}

std::vector<double> countedNumbers(std::size_t count) {
    std::vector<double> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0.0);
    return numbers;
}

void writeFile(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

Result<WholeVolume> readVolume(const std::filesystem::path& path, const proto::VolumeSourceOptions& options) {
    QuietProgress progress;
    auto source = prep::openVolumeSource(options, path, progress);
    if (!source) return source.error();
    WholeVolume volume;
    volume.format = (*source)->format();
    volume.shape = (*source)->shape();
    volume.sequential = (*source)->sequential();
    const std::size_t slice = volume.shape.voxelsOfSlice();
    volume.values.resize(volume.shape.voxels());
    for (std::uint32_t z = 0; z < volume.shape.nz; ++z) {
        const auto status = (*source)->read(z, z + 1, std::span(volume.values).subspan(z * slice, slice));
        if (!status) return status.error();
    }
    volume.notes = progress.notes;
    return volume;
}

std::vector<float> readSlices(const std::filesystem::path& path, const std::vector<std::uint32_t>& slices,
                              const proto::VolumeSourceOptions& options) {
    QuietProgress progress;
    auto source = prep::openVolumeSource(options, path, progress);
    if (!source) return {};
    const std::size_t size = (*source)->shape().voxelsOfSlice();
    std::vector<float> values(size * slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) {
        const auto to = std::span(values).subspan(i * size, size);
        if (!(*source)->read(slices[i], slices[i] + 1, to)) return {};
    }
    return values;
}

std::vector<double> slicesOf(const std::vector<double>& numbers, std::size_t size,
                             const std::vector<std::uint32_t>& slices) {
    std::vector<double> chosen;
    for (const std::uint32_t slice : slices) {
        const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(slice * size);
        chosen.insert(chosen.end(), begin, begin + static_cast<std::ptrdiff_t>(size));
    }
    return chosen;
}

std::string volumeError(const std::filesystem::path& path, const proto::VolumeSourceOptions& options) {
    const auto volume = readVolume(path, options);
    if (volume) return "";
    return std::string(name(volume.error().code)) + ": " + volume.error().toString();
}

glm::dvec3 worldOf(const prep::VolumeShape& shape, double x, double y, double z) {
    return glm::dvec3(shape.indexToWorld * glm::dvec4(x, y, z, 1.0));
}

}  // namespace mote::test
