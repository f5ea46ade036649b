// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "preprocess/readers/npy/npy_array.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/volume/archive_stream.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// NumPy arrays as volumes: .npy, or an array of a .npz archive. Called from one thread.

constexpr std::uint64_t mostHeld = 1u << 30;  // bytes of an array in Fortran's order
constexpr std::size_t mostArraysListed = 20;

/// An array in Fortran's order, its first index the fastest, as the bytes that it has in C order.
class FortranStream : public ByteStream {
  public:
    /// `shape` in the array's order.
    FortranStream(ByteStreamPtr stored, std::array<std::uint64_t, 4> shape, std::size_t width)
        : stored_(std::move(stored)), shape_(shape), width_(width) {}
    std::string name() const override { return stored_->name(); }
    bool sequential() const override { return false; }
    std::optional<std::uint64_t> size() const override { return stored_->size(); }
    std::uint64_t mostBytes() const override { return stored_->mostBytes(); }
    Status seek(std::uint64_t offset) override {
        at_ = std::min(offset, mostBytes());
        return success();
    }

    Result<std::size_t> read(std::span<char> bytes) override {
        MOTE_RETURN_IF_ERROR(hold());
        std::size_t done = 0;
        while (done < bytes.size() && at_ < held_.size()) {
            const auto within = static_cast<std::size_t>(at_ % width_);
            const std::size_t count = std::min(bytes.size() - done, width_ - within);
            std::memcpy(bytes.data() + done, held_.data() + placeOf(at_ / width_) + within, count);
            done += count;
            at_ += count;
        }
        return done;
    }

  private:
    Status hold() {
        if (!held_.empty()) return success();
        held_.resize(static_cast<std::size_t>(stored_->mostBytes()));
        MOTE_RETURN_IF_ERROR(stored_->seek(0));
        MOTE_ASSIGN_OR_RETURN(const auto got, stored_->read(held_));
        if (got == held_.size()) return success();
        return corrupt(name(), "ends before its last value");
    }

    /// The place of the value that is number `index` in C order.
    std::size_t placeOf(std::uint64_t index) const {
        std::array<std::uint64_t, 4> indices{};
        for (std::size_t i = shape_.size(); i-- > 0;) {
            indices[i] = index % shape_[i];
            index /= shape_[i];
        }
        std::uint64_t place = 0;
        for (std::size_t i = shape_.size(); i-- > 0;) place = place * shape_[i] + indices[i];
        return static_cast<std::size_t>(place) * width_;
    }

    ByteStreamPtr stored_;
    std::array<std::uint64_t, 4> shape_;
    std::size_t width_;
    std::vector<char> held_;
    std::uint64_t at_ = 0;
};

/// An array that was chosen, and which of its volumes the rest of the field asks for.
struct Chosen {
    NpyArray array;
    std::string volume;
};

std::string shapeText(const NpyArray& array) {
    std::string text;
    for (const auto length : array.header.shape)
        text += fmt::format("{}{}", text.empty() ? "" : " x ", length);
    return text.empty() ? "one number" : text;
}

bool isVolume(const NpyArray& array) {
    const std::size_t dimensions = array.header.shape.size();
    return dimensions == 3 || dimensions == 4;
}

Error several(const std::string& where, const std::vector<NpyArray>& arrays, const std::string& what) {
    std::string list;
    for (std::size_t i = 0; i < std::min(arrays.size(), mostArraysListed); ++i) {
        list += fmt::format("{}{} ({})", i == 0 ? "" : ", ", arrays[i].name, shapeText(arrays[i]));
    }
    if (arrays.size() > mostArraysListed)
        list += fmt::format(" and {} more", arrays.size() - mostArraysListed);
    return {
        what.empty() ? ErrorCode::unsupported : ErrorCode::notFound, where,
        (what.empty() ? "holds several arrays: ask for one as the field; it holds " : what + "; it holds ") +
            list};
}

Result<Chosen> choose(const std::filesystem::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(auto arrays, openNpyArrays(path));
    const bool archive = arrays.size() > 1 || !arrays.front().name.empty();
    if (!archive) return Chosen{std::move(arrays.front()), field};
    const std::string file = path.filename().string();
    const auto named = [&](std::string_view name) {
        return std::find_if(arrays.begin(), arrays.end(),
                            [&](const NpyArray& each) { return each.name == name; });
    };
    if (const auto whole = named(field); whole != arrays.end()) return Chosen{std::move(*whole), ""};
    const auto colon = field.rfind(':');
    const std::string name = field.substr(0, std::min(colon, field.size()));
    const std::string rest = colon == std::string::npos ? "" : field.substr(colon + 1);
    if (const auto found = named(name); !name.empty() && found != arrays.end()) {
        return Chosen{std::move(*found), rest};
    }
    const auto count = std::count_if(arrays.begin(), arrays.end(), isVolume);
    if (!name.empty() && !(count == 1 && colon == std::string::npos &&
                           field.find_first_not_of("0123456789") == std::string::npos)) {
        return several(file, arrays, fmt::format("has no array of the name \"{:.40}\"", name));
    }
    if (count > 1) return several(file, arrays, "");
    const auto only = std::find_if(arrays.begin(), arrays.end(), isVolume);
    if (only == arrays.end()) return several(file, arrays, "has no array of three or four dimensions");
    return Chosen{std::move(*only), name.empty() ? rest : name};
}

Result<ScalarType> typeOf(const NpyArray& array) {
    const NpyField& field = array.header.fields[0];
    const auto type = fmt::format("{}{}", field.kind, field.bytes * 8);
    const auto known = scalarType(type);
    if (!array.header.structured() && field.count == 1 && known) return *known;
    return unsupported(
        array.part.where,
        "holds no plain numbers: integers and floats of up to 8 bytes are read, each voxel one");
}

/// Volumes, z, y, x.
Result<std::array<std::uint64_t, 4>> shapeOf(const NpyArray& array) {
    if (!isVolume(array)) {
        return unsupported(
            array.part.where,
            fmt::format(
                "is an array of {}: a volume has three dimensions, z, y and x, or a fourth before them "
                "that counts volumes",
                shapeText(array)));
    }
    std::array<std::uint64_t, 4> shape{1, 1, 1, 1};
    std::copy_backward(array.header.shape.begin(), array.header.shape.end(), shape.end());
    return shape;
}

Result<ByteStreamPtr> valuesOf(const NpyArray& array, const std::array<std::uint64_t, 4>& shape,
                               std::size_t width) {
    MOTE_ASSIGN_OR_RETURN(auto whole, archiveStream(array.part));
    if (array.part.checksum && shape[0] > 1) MOTE_RETURN_IF_ERROR(checkWhole(*whole));
    MOTE_ASSIGN_OR_RETURN(auto stored, partStream(std::move(whole), array.header.dataOffset));
    if (!array.header.fortranOrder) return stored;
    if (stored->mostBytes() > mostHeld) {
        return Error{
            ErrorCode::resourceExhausted, array.part.where,
            fmt::format(
                "is in Fortran's order, which is held in memory, and has {} MiB of the {} that may be: "
                "save numpy.ascontiguousarray of it",
                stored->mostBytes() >> 20U, mostHeld >> 20U)};
    }
    return ByteStreamPtr(std::make_unique<FortranStream>(std::move(stored), shape, width));
}

}  // namespace

bool beginsAsNpy(std::string_view bytes) {
    return bytes.starts_with("\x93NUMPY");
}

Result<std::vector<VolumeField>> npyFields(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(path));
    std::vector<VolumeField> fields;
    for (const auto& array : arrays) {
        if (isVolume(array)) fields.push_back({array.name});
    }
    return fields;
}

Result<std::vector<std::string>> npySteps(const std::filesystem::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(const auto chosen, choose(path, field));
    MOTE_ASSIGN_OR_RETURN(const auto shape, shapeOf(chosen.array));
    VolumeParts parts;
    parts.volumes = shape[0];
    if (parts.volumes < 2 || !chosen.volume.empty()) return std::vector<std::string>{field};
    auto fields = fieldsOfSeries("", parts);
    for (auto& each : fields) {
        if (!chosen.array.name.empty()) each = fmt::format("{}:{}", chosen.array.name, each);
    }
    return fields;
}

Result<std::unique_ptr<VolumeSource>> openNpy(const std::filesystem::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(const auto chosen, choose(path, field));
    const NpyArray& array = chosen.array;
    MOTE_ASSIGN_OR_RETURN(const auto shape, shapeOf(array));
    SampleFormat samples;
    MOTE_ASSIGN_OR_RETURN(samples.type, typeOf(array));
    samples.bigEndian = array.header.fields[0].bigEndian;
    VolumeParts parts;
    parts.volumes = shape[0];
    VolumeShape made;
    made.type = samples.type == ScalarType::f16 ? ScalarType::f32 : samples.type;
    MOTE_RETURN_IF_ERROR(setDimensions(made, shape[3], shape[2], shape[1], array.part.where));
    if (parts.volumes == 0) return corrupt(array.part.where, "has no volumes");
    MOTE_ASSIGN_OR_RETURN(parts, chooseParts(chosen.volume, parts, array.part.where));
    made.notes.push_back(
        fmt::format("{}: the array's dimensions are {}z, y and x; it says no size of a voxel",
                    array.part.where, array.header.shape.size() == 4 ? "volumes, " : ""));
    MOTE_ASSIGN_OR_RETURN(auto data, valuesOf(array, shape, array.header.itemBytes));
    return StreamVolume::make("npy", std::move(made), samples, std::move(data), StreamVolume::Ending::exact,
                              parts);
}

}  // namespace mote::prep
