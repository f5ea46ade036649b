// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// MRC2014 and CCP4 maps (ccpem.ac.uk/mrc_format). MrcHeader: what the first 1024 bytes say, checked. Parsed
// from bytes that nobody vouches for. Called from one thread.

struct MrcHeader {
    VolumeShape shape;
    VolumeParts parts;  ///< how many there are; the first one is chosen
    SampleFormat samples;
    std::uint64_t offset = 0;  ///< bytes before the numbers

    /// How many bytes of a file's beginning parse() needs.
    static constexpr std::size_t bytes = 1024;

    /// Errors, at the file's name and the field: corrupt, unsupported.
    static Result<MrcHeader> parse(std::string_view bytes, const std::string& file);
};

// Where fields lie, in bytes: ccpem.ac.uk/mrc_format/mrc2014.php.
constexpr std::size_t sizeAt = 0, modeAt = 12, startAt = 16, gridAt = 28, cellAt = 40, anglesAt = 52,
                      axesAt = 64, groupAt = 88, extendedAt = 92, imodAt = 152, imodFlagsAt = 156,
                      originAt = 196, mapAt = 208, stampAt = 212;
constexpr std::uint32_t imodStamp = 1146047817, imodSigned = 1;
constexpr int firstStack = 401, lastStack = 630;

class MrcReader {
  public:
    MrcReader(std::string_view bytes, const std::string& file, MrcHeader& header)
        : bytes_(bytes), file_(file), header_(header) {}

    Status read() {
        MOTE_RETURN_IF_ERROR(findOrder());
        header_.samples.bigEndian = big_;
        MOTE_RETURN_IF_ERROR(readType());
        MOTE_RETURN_IF_ERROR(readSizes());
        const auto extended = integer(extendedAt);
        if (extended < 0) return corrupt("nsymbt", fmt::format("says {} bytes", extended));
        header_.offset = MrcHeader::bytes + static_cast<std::uint64_t>(extended);
        return readPlace();
    }

  private:
    Error corrupt(const char* field, std::string message) const {
        return {ErrorCode::corrupt, file_ + ": " + field, std::move(message)};
    }
    Error unsupported(const char* field, std::string message) const {
        return {ErrorCode::unsupported, file_ + ": " + field, std::move(message)};
    }
    void note(const char* field, const std::string& sentence) {
        header_.shape.notes.push_back(fmt::format("{}: {}: {}", file_, field, sentence));
    }
    std::int32_t integer(std::size_t at) const { return loadNumber<std::int32_t>(bytes_.data() + at, big_); }
    std::array<std::int64_t, 3> integers(std::size_t at) const {
        return {integer(at), integer(at + 4), integer(at + 8)};
    }
    glm::dvec3 reals(std::size_t at) const {
        glm::dvec3 made;
        for (int i = 0; i < 3; ++i) {
            made[i] = static_cast<double>(
                loadNumber<float>(bytes_.data() + at + 4 * static_cast<std::size_t>(i), big_));
        }
        return made;
    }

    /// Finds it by the machine stamp; if that is none, by which order makes the mode and the axes sensible.
    Status findOrder() {
        const auto stamp = static_cast<unsigned char>(bytes_[stampAt]);
        big_ = stamp == 0x11;
        if (stamp == 0x11 || stamp == 0x44) return success();
        for (const bool big : {false, true}) {
            big_ = big;
            const auto mode = integer(modeAt);
            if (mode < 0 || mode > 127) continue;
            note("MACHST", fmt::format("is no stamp that is known: numbers are read as {} endian",
                                       big ? "big" : "little"));
            return success();
        }
        return corrupt("MACHST", "says no byte order, and neither makes sense");
    }

    Status readType() {
        const auto mode = integer(modeAt);
        const bool imod = loadNumber<std::uint32_t>(bytes_.data() + imodAt, big_) == imodStamp;
        const bool isSigned =
            (loadNumber<std::uint32_t>(bytes_.data() + imodFlagsAt, big_) & imodSigned) != 0;
        const auto type = mode == 0    ? std::optional(imod && !isSigned ? ScalarType::u8 : ScalarType::i8)
                          : mode == 1  ? std::optional(ScalarType::i16)
                          : mode == 2  ? std::optional(ScalarType::f32)
                          : mode == 6  ? std::optional(ScalarType::u16)
                          : mode == 12 ? std::optional(ScalarType::f16)
                                       : std::nullopt;
        if (!type) {
            const char* const what = mode == 3 || mode == 4 ? "complex numbers, a transform"
                                     : mode == 16           ? "colours"
                                     : mode == 101          ? "numbers of 4 bits"
                                                            : "another kind of numbers";
            return unsupported("MODE", fmt::format("is {} ({}); 0, 1, 2, 6 and 12 are read", mode, what));
        }
        header_.samples.type = *type;
        header_.shape.type = *type == ScalarType::f16 ? ScalarType::f32 : *type;
        if (mode == 0 && imod && !isSigned) note("MODE", "IMOD says that its bytes have no sign");
        return success();
    }

    Status readSizes() {
        const auto size = integers(sizeAt);
        grid_ = integers(gridAt);
        for (const auto length : size) {
            if (length < 0)
                return corrupt("NX", fmt::format("says {} x {} x {} voxels", size[0], size[1], size[2]));
        }
        auto slices = size[2];
        const auto group = integer(groupAt);
        if (group >= firstStack && group <= lastStack && grid_[2] > 0) {
            if (slices % grid_[2] != 0) {
                return corrupt("ISPG",
                               fmt::format("says volumes of {} slices, and there are {}", grid_[2], slices));
            }
            header_.parts.volumes = static_cast<std::uint64_t>(slices / grid_[2]);
            slices = grid_[2];
        } else if (group == 0 && slices > 1) {
            note("ISPG", "says a stack of pictures; they are taken as the slices of a volume");
        }
        if (header_.parts.volumes == 0) return corrupt("NZ", "says no volumes");
        const auto whole = [](std::int64_t length) { return static_cast<std::uint64_t>(length); };
        return setDimensions(header_.shape, whole(size[0]), whole(size[1]), whole(slices), file_ + ": NX");
    }

    /// Columns, rows and sections are x, y and z in some order.
    Result<std::array<int, 3>> axes() {
        std::array<int, 3> axes{};
        const auto said = integers(axesAt);
        if (said[0] == 0 && said[1] == 0 && said[2] == 0) {
            note("MAPC", "does not say which axis columns lie along; they are taken as x, rows as y");
            return std::array<int, 3>{0, 1, 2};
        }
        auto sorted = said;
        std::sort(sorted.begin(), sorted.end());
        if (sorted != std::array<std::int64_t, 3>{1, 2, 3}) {
            return corrupt("MAPC", fmt::format("says axes {}, {} and {}", said[0], said[1], said[2]));
        }
        for (std::size_t i = 0; i < 3; ++i) axes[i] = static_cast<int>(said[i]) - 1;
        return axes;
    }

    /// The edges of the cell as vectors: a along x, b in the plane of x and y (the convention of PDB files).
    Result<glm::dmat3> cell() {
        glm::dvec3 lengths = reals(cellAt), angles = reals(anglesAt);
        if (!(lengths.x > 0 && lengths.y > 0 && lengths.z > 0)) {
            note("CELLA", "says no size of a voxel, which was taken as 1");
            for (std::size_t i = 0; i < 3; ++i) lengths[static_cast<int>(i)] = static_cast<double>(grid_[i]);
        } else {
            header_.shape.worldUnit = "angstrom";
        }
        const bool right = angles == glm::dvec3(90.0) || angles == glm::dvec3(0.0);
        if (right) return glm::dmat3(lengths.x, 0, 0, 0, lengths.y, 0, 0, 0, lengths.z);
        const glm::dvec3 c = glm::cos(glm::radians(angles)), s = glm::sin(glm::radians(angles));
        const double along = (c.x - c.y * c.z) / s.z, up = 1.0 - c.y * c.y - along * along;
        if (!(up > 0.0) || !(s.z > 0.0)) return corrupt("CELLB", "says angles of which there is no cell");
        note("CELLB", fmt::format("says a cell of {:g}, {:g} and {:g} degrees: the grid is oblique", angles.x,
                                  angles.y, angles.z));
        return glm::dmat3(glm::dvec3(lengths.x, 0, 0), lengths.y * glm::dvec3(c.z, s.z, 0),
                          lengths.z * glm::dvec3(c.y, along, std::sqrt(up)));
    }

    Status readPlace() {
        const auto size = integers(sizeAt);
        MOTE_ASSIGN_OR_RETURN(const auto order, axes());
        for (std::size_t i = 0; i < 3; ++i) {
            const auto axis = static_cast<std::size_t>(order[i]);
            if (grid_[axis] > 0) continue;
            note("MX", fmt::format("says {} intervals along {}; they are taken as its voxels", grid_[axis],
                                   "xyz"[axis]));
            grid_[axis] = size[i];
        }
        MOTE_ASSIGN_OR_RETURN(auto steps, cell());
        for (int i = 0; i < 3; ++i) steps[i] /= static_cast<double>(grid_[static_cast<std::size_t>(i)]);
        glm::dmat3 made;
        for (int i = 0; i < 3; ++i) made[i] = steps[order[static_cast<std::size_t>(i)]];
        return setPlacement(header_.shape, made, origin(made), file_ + ": CELLA");
    }

    /// ORIGIN where that is one, else the start of columns, rows and sections.
    glm::dvec3 origin(const glm::dmat3& steps) {
        const auto start = integers(startAt);
        const glm::dvec3 said = reals(originAt);
        glm::dvec3 counted(0.0);
        for (int i = 0; i < 3; ++i)
            counted += steps[i] * static_cast<double>(start[static_cast<std::size_t>(i)]);
        if (said == glm::dvec3(0.0)) return counted;
        if (counted != glm::dvec3(0.0) && counted != said) {
            note("ORIGIN",
                 fmt::format("goes before NXSTART, NYSTART and NZSTART ({}, {}, {}), which were left aside",
                             start[0], start[1], start[2]));
        }
        return said;
    }

    std::string_view bytes_;
    const std::string& file_;
    MrcHeader& header_;
    bool big_ = false;
    std::array<std::int64_t, 3> grid_{};
};

Result<MrcHeader> MrcHeader::parse(std::string_view bytes, const std::string& file) {
    if (bytes.size() < MrcHeader::bytes)
        return Error{ErrorCode::corrupt, file, "is shorter than the head of a map"};
    MrcHeader header;
    MOTE_RETURN_IF_ERROR(MrcReader(bytes, file, header).read());
    return header;
}

}  // namespace

bool beginsAsMrc(std::string_view bytes) {
    return bytes.size() >= MrcHeader::bytes && bytes.substr(mapAt, 3) == "MAP" &&
           (bytes[mapAt + 3] == ' ' || bytes[mapAt + 3] == '\0');
}

Result<std::unique_ptr<VolumeSource>> openMrc(const std::filesystem::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(*file, MrcHeader::bytes));
    MOTE_ASSIGN_OR_RETURN(auto header, MrcHeader::parse(head, file->name()));
    MOTE_ASSIGN_OR_RETURN(const auto parts, chooseParts(field, header.parts, file->name()));
    MOTE_ASSIGN_OR_RETURN(auto data, partStream(std::move(file), header.offset));
    return StreamVolume::make("mrc", std::move(header.shape), header.samples, std::move(data),
                              StreamVolume::Ending::end, parts);
}

Result<VolumeParts> partsOfMrc(const std::filesystem::path& path) {
    return partsOfHeader<MrcHeader>(path);
}

}  // namespace mote::prep
