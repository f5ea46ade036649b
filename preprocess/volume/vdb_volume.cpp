// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_formats.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "preprocess/volume/byte_stream.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// Bytes of data that the process has mapped; 0 if that is not known.
std::uint64_t mappedData() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t size = 0, resident = 0, shared = 0, text = 0, library = 0, data = 0;
    file >> size >> resident >> shared >> text >> library >> data;
    return file ? data * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

/// While it lives, the process gets no more than some memory beyond what it has: an allocation that would
/// need it throws std::bad_alloc. For a library that believes every length in a file. The limit is the
/// process's own (RLIMIT_DATA): one at a time, while no other thread needs much.
class DataLimit {
  public:
    /// `more` in bytes. Where the system does not say what the process has, nothing is limited.
    explicit DataLimit(std::uint64_t more) {
        const auto now = mappedData();
        if (now == 0 || ::getrlimit(RLIMIT_DATA, &before_) != 0) return;
        rlimit limit = before_;
        limit.rlim_cur = std::min<rlim_t>(before_.rlim_cur, now + more);
        set_ = ::setrlimit(RLIMIT_DATA, &limit) == 0;
    }
    ~DataLimit() {
        if (set_) ::setrlimit(RLIMIT_DATA, &before_);
    }
    DataLimit(const DataLimit&) = delete;
    DataLimit& operator=(const DataLimit&) = delete;

  private:
    rlimit before_{};
    bool set_ = false;
};

// Its voxels are held between reads; a thinner window reads the grid's nodes more often.
constexpr std::uint64_t windowBytes = 1u << 28;
constexpr std::uint32_t leafSize = 8;

/// What reading takes at most: a window and its nodes, and the nodes of the whole grid without their voxels,
/// which take less memory than their masks and values take in the file.
std::uint64_t mostMemory(const fs::path& path) {
    std::error_code code;
    const auto size = fs::file_size(path, code);
    return 4 * windowBytes + (code ? 0 : 4 * size);
}

std::optional<ScalarType> typeOf(const openvdb::GridBase& grid) {
    if (grid.isType<openvdb::FloatGrid>()) return ScalarType::f32;
    if (grid.isType<openvdb::DoubleGrid>()) return ScalarType::f64;
    if (grid.isType<openvdb::Int32Grid>()) return ScalarType::i32;
    return std::nullopt;
}

/// The components of OpenVDB's word for a type, "vec3s".
std::uint64_t componentsOf(std::string_view type) {
    constexpr std::string_view vector = "vec";
    const bool several =
        type.size() > vector.size() && type.starts_with(vector) && type[3] >= '2' && type[3] <= '4';
    return several ? static_cast<std::uint64_t>(type[3] - '0') : 1;
}

template <class Grid>
void copyBox(const openvdb::GridBase& grid, const openvdb::CoordBBox& box, std::span<float> values) {
    openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, values.data());
    openvdb::tools::copyToDense(static_cast<const Grid&>(grid), dense, true);
}

/// Goes through a file's grids. io::File looks at no stream's state: where a file is cut it reads zeros, and
/// counts that are damaged make it go on for hours. Here the end of the file throws.
class GridReader : public openvdb::io::Archive {
  public:
    explicit GridReader(const fs::path& path) {
        file_.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
        file_.open(path, std::ios::binary);
        metadata_->setSeekable(true);
        openvdb::io::setStreamMetadataPtr(file_, metadata_, false);
        readHeader(file_);
        setFormatVersion(file_);
        setLibraryVersion(file_);
        setDataCompression(file_);
        openvdb::MetaMap().readMeta(file_);
        left_ = readGridCount(file_);
    }

    /// Goes to the next grid and reads what stands before its nodes. False if there is none.
    bool next() {
        if (left_ <= 0) return false;
        --left_;
        if (grid_) descriptor_.seekToEnd(file_);
        descriptor_ = {};
        grid_ = descriptor_.read(file_);
        descriptor_.seekToGrid(file_);
        readGridCompression(file_);
        grid_->readMeta(file_);
        grid_->readTransform(file_);
        return true;
    }

    const openvdb::io::GridDescriptor& descriptor() const { return descriptor_; }
    const openvdb::GridBase::Ptr& grid() const { return grid_; }

    /// The grid's nodes, and its voxels in a box of indices. As readGrid() of the base does, but for the
    /// root: that would prune the tree, and a leaf whose first voxel is no number is alike all over to it, as
    /// nothing differs from that.
    template <class Grid>
    void readBox(const openvdb::CoordBBox& box) {
        descriptor_.seekToGrid(file_);
        readGridCompression(file_);
        metadata_->setHalfFloat(grid_->saveFloatAsHalf());
        grid_->readMeta(file_);
        // Inactive voxels are told by the class of the grid and its background.
        openvdb::io::setGridClass(file_, grid_->getGridClass());
        openvdb::io::setGridBackgroundValuePtr(file_, nullptr);
        metadata_->setLeaf(0);
        grid_->removeMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD);
        grid_->readTransform(file_);
        grid_->readTopology(file_);
        auto& root = static_cast<Grid&>(*grid_).tree().root();
        for (auto child = root.beginChildOn(); child; ++child) {
            child->readBuffers(file_, box, grid_->saveFloatAsHalf());
        }
    }

  private:
    openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
    std::ifstream file_;  // keeps a pointer to metadata_
    std::int32_t left_ = 0;
    openvdb::io::GridDescriptor descriptor_;
    openvdb::GridBase::Ptr grid_;
};

class VdbVolume : public VolumeSource {
  public:
    explicit VdbVolume(const fs::path& path) : path_(path), name_(path.filename().string()) {}

    std::string format() const override { return "vdb"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return true; }

    /// Finds the grid and its box by what stands before its nodes.
    Status open(const std::string& field) {
        return guarded([&]() -> Status {
            GridReader reader(path_);
            MOTE_ASSIGN_OR_RETURN(const auto index, choose(reader, field));
            index_ = index;
            grid_ = printableText(reader.descriptor().gridName());
            if (reader.descriptor().isInstance()) return unsupported("shares its voxels with another one");
            return setShape(*reader.grid());
        });
    }

    Result<std::vector<VolumeField>> fields() const {
        std::vector<VolumeField> all;
        std::size_t readable = 0;
        const Status status = guarded([&]() -> Status {
            for (GridReader reader(path_); reader.next();) {
                const auto& grid = *reader.grid();
                const std::string type = grid.valueType();
                const bool first = typeOf(grid).has_value() && readable++ == 0;
                all.insert(first ? all.begin() : all.end(),
                           {reader.descriptor().gridName(), componentsOf(type), type});
            }
            return success();
        });
        if (!status) return status.error();
        return all;
    }

    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
        const auto slice = static_cast<std::size_t>(shape_.voxelsOfSlice());
        while (z0 < z1) {
            if (!window_ || z0 < windowBegin_ || z0 >= windowEnd_) MOTE_RETURN_IF_ERROR(load(z0));
            const std::uint32_t end = std::min(z1, windowEnd_);
            const auto box = slices(z0, end);
            const auto part = values.first(slice * (end - z0));
            switch (shape_.type) {
                case ScalarType::f64:
                    copyBox<openvdb::DoubleGrid>(*window_, box, part);
                    break;
                case ScalarType::i32:
                    copyBox<openvdb::Int32Grid>(*window_, box, part);
                    break;
                default:
                    copyBox<openvdb::FloatGrid>(*window_, box, part);
            }
            values = values.subspan(part.size());
            z0 = end;
        }
        return success();
    }

  private:
    template <class Work>
    Status guarded(Work work) const {
        try {
            const DataLimit limit(mostMemory(path_));
            return work();
        } catch (const std::bad_alloc&) {
            return Error{ErrorCode::resourceExhausted, name_,
                         "asks for more memory than there is, or than a file of its size can need"};
        } catch (const std::length_error&) {
            return corrupt(name_, "says a length that nothing can have");
        } catch (const std::ios_base::failure&) {
            return corrupt(name_, "ends before its grids do, or cannot be read");
        } catch (const std::exception& error) {
            return corrupt(name_, std::string("cannot be read: ") + error.what());
        }
    }

    std::string where() const { return fmt::format("{}: grid \"{:.40}\"", name_, grid_); }
    Error unsupported(std::string message) const {
        return {ErrorCode::unsupported, where(), std::move(message)};
    }

    /// Goes on to the grid and says the how manieth it is.
    Result<int> choose(GridReader& reader, const std::string& field) {
        std::optional<Error> refused;
        for (int index = 0; reader.next(); ++index) {
            if (!field.empty() && reader.descriptor().gridName() != field) continue;
            if (typeOf(*reader.grid())) return index;
            if (refused) continue;
            grid_ = printableText(reader.descriptor().gridName());
            refused =
                unsupported(fmt::format("holds values of type {}; only float, double and int32 are drawn",
                                        reader.grid()->valueType()));
        }
        if (refused) return *refused;
        return notFound(name_, field.empty() ? "holds no grid"
                                             : fmt::format("holds no grid of the name \"{:.40}\"", field));
    }

    Status setShape(const openvdb::GridBase& grid) {
        const auto least = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
        const auto greatest = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
        if (!least || !greatest) return unsupported("does not say which box its active voxels lie in");
        std::array<std::uint64_t, 3> sizes{};
        for (int i = 0; i < 3; ++i) {
            const std::int64_t size = std::int64_t{greatest->value()[i]} - least->value()[i] + 1;
            if (size > 0) sizes[static_cast<std::size_t>(i)] = static_cast<std::uint64_t>(size);
        }
        MOTE_RETURN_IF_ERROR(setDimensions(shape_, sizes[0], sizes[1], sizes[2], where()));
        shape_.type = *typeOf(grid);
        first_ = openvdb::Coord(least->value());
        if (!grid.transform().isLinear()) return unsupported("has a transform that is not linear");
        const openvdb::Mat4d map = grid.transform().baseMap()->getAffineMap()->getMat4();  // of row vectors
        glm::dmat3 steps;
        for (int i = 0; i < 3; ++i) steps[i] = {map[i][0], map[i][1], map[i][2]};
        const openvdb::Vec3d origin = grid.transform().indexToWorld(first_);
        return setPlacement(shape_, steps, {origin[0], origin[1], origin[2]}, where());
    }

    openvdb::CoordBBox slices(std::uint32_t z0, std::uint32_t z1) const {
        const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
            return first_.offsetBy(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
        };
        return {at(0, 0, z0), at(shape_.nx - 1, shape_.ny - 1, z1 - 1)};
    }

    /// Reads the voxels of the slices from `z` on, as many as a window has.
    Status load(std::uint32_t z) {
        const std::uint64_t fitting = windowBytes / (shape_.voxelsOfSlice() * bytesOf(shape_.type));
        const std::uint64_t thickness = std::max<std::uint64_t>(fitting / leafSize * leafSize, leafSize);
        windowBegin_ = z;
        windowEnd_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(z + thickness, shape_.nz));
        window_.reset();
        return guarded([&]() -> Status {
            GridReader reader(path_);
            for (int index = 0; index <= index_; ++index) {
                if (!reader.next()) return changed();
            }
            if (typeOf(*reader.grid()) != shape_.type) return changed();
            const auto box = slices(windowBegin_, windowEnd_);
            switch (shape_.type) {
                case ScalarType::f64:
                    reader.readBox<openvdb::DoubleGrid>(box);
                    break;
                case ScalarType::i32:
                    reader.readBox<openvdb::Int32Grid>(box);
                    break;
                default:
                    reader.readBox<openvdb::FloatGrid>(box);
            }
            window_ = reader.grid();
            return success();
        });
    }

    Error changed() const { return corrupt(name_, "has changed while it was read"); }

    fs::path path_;
    std::string name_;
    std::string grid_;  ///< its name
    int index_ = 0;     ///< of the grid in the file
    VolumeShape shape_;
    openvdb::Coord first_;           ///< index of the first voxel in the grid
    openvdb::GridBase::Ptr window_;  ///< the voxels of slices [windowBegin_, windowEnd_)
    std::uint32_t windowBegin_ = 0, windowEnd_ = 0;
};

}  // namespace

bool beginsAsVdb(std::string_view bytes) {
    return bytes.starts_with(std::string_view("\x20\x42\x44\x56\0\0\0\0", 8));
}

Result<std::vector<VolumeField>> vdbFields(const fs::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, fileStream(path));
    openvdb::initialize();
    return VdbVolume(path).fields();
}

Result<std::unique_ptr<VolumeSource>> openVdb(const fs::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(const auto file, fileStream(path));  // says in our words what is wrong with it
    openvdb::initialize();
    auto volume = std::make_unique<VdbVolume>(path);
    MOTE_RETURN_IF_ERROR(volume->open(field));
    return std::unique_ptr<VolumeSource>(std::move(volume));
}

}  // namespace mote::prep
