// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/resident_steps.h"

#include <algorithm>
#include <glm/vec3.hpp>
#include <string>

#include "protocol/base/mote_check.h"
#include "server/render/plan/octree_cell.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

/// Each brick's own cells and one more on every side, since interpolation looks that far.
struct Reach {
    std::uint32_t begin, end;
};

Reach reach(std::uint32_t brick, std::uint32_t brickCells, std::uint32_t size) {
    const std::uint32_t begin = brick * brickCells;
    return {begin == 0 ? 0 : begin - 1, std::min(size, begin + brickCells + 1)};
}

struct DevicePoint {
    std::uint32_t x, y, z, leaf;
};

[[noreturn]] void damaged(const char* array, std::size_t index) {
    throw storage::StorageError(Error{ErrorCode::corrupt,
                                      std::string(array) + "[" + std::to_string(index) + "]",
                                      "the leaves do not describe the points that are there"});
}

/// A leaf's cell: its corner in units of 2^-31 of the box, and how its points' places are scaled to them.
struct LeafFrame {
    glm::uvec3 corner;
    std::uint32_t level;

    /// The middle of place p, (2 p + 1) / 2^17 of the cell's edge.
    std::uint32_t place(std::uint32_t base, std::uint16_t p) const {
        const std::uint64_t middle = (2ULL * p + 1) << 14;  // 2^-31 of the cell's edge
        return base + static_cast<std::uint32_t>(middle >> level);
    }
};

LeafFrame leafFrame(const storage::OctreeNodes& nodes, std::size_t node) {
    if (node >= nodes.size() || nodes.level[node] > deepestLevel) damaged("/leaves/node", node);
    const std::uint32_t level = nodes.level[node];
    const glm::uvec3 place = cellPlace(nodes.morton[node]);
    const auto corner = [&](std::uint32_t index) {
        return static_cast<std::uint32_t>((std::uint64_t{index} << 31) >> level);
    };
    return {{corner(place.x), corner(place.y), corner(place.z)}, level};
}

/// The last leaf that begins at or before a point.
std::size_t leafAt(const storage::Leaves& leaves, std::uint64_t point) {
    const auto after = std::upper_bound(leaves.pointBegin.begin(), leaves.pointBegin.end(), point);
    if (after == leaves.pointBegin.begin()) damaged("/leaves/point_begin", 0);
    return static_cast<std::size_t>(after - leaves.pointBegin.begin()) - 1;
}

/// Where [begin, begin + count) of the step lies in a chunk that begins at `chunkBegin`, cut to its size.
std::pair<std::uint32_t, std::uint32_t> within(std::uint64_t begin, std::uint64_t count,
                                               std::uint64_t chunkBegin, std::uint64_t size) {
    const auto cut = [&](std::uint64_t at) {
        return static_cast<std::uint32_t>(std::clamp(at, chunkBegin, chunkBegin + size) - chunkBegin);
    };
    return {cut(begin), cut(begin + count)};
}

std::vector<DevicePoint> decode(const storage::ParticleStep& step, std::uint64_t begin, std::uint64_t count,
                                std::size_t firstLeaf) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    const auto positions = step.positions(begin, count);
    std::vector<DevicePoint> points(count);
    std::uint64_t done = 0;
    for (std::size_t leaf = firstLeaf; done < count; ++leaf) {
        if (leaf >= leaves.size()) damaged("/leaves/point_count", leaves.size() - 1);
        const LeafFrame frame = leafFrame(nodes, leaves.node[leaf]);
        const auto [first, last] = within(leaves.pointBegin[leaf], leaves.pointCount[leaf], begin, count);
        if (first != done) damaged("/leaves/point_begin", leaf);
        for (; done < last; ++done) {
            const auto& p = positions[done];
            points[done] = {frame.place(frame.corner.x, p.x), frame.place(frame.corner.y, p.y),
                            frame.place(frame.corner.z, p.z), static_cast<std::uint32_t>(leaf - firstLeaf)};
        }
    }
    return points;
}

}  // namespace

StepPoints::StepPoints(const storage::ParticleStep& step)
    : pointCount_(step.pointCount()),
      chunks_((pointCount_ + chunkPoints - 1) / chunkPoints),
      selected_(chunks_.size()) {}

void StepPoints::select(const PointsPlan& layer) {
    if (layer.selection == selection_ && layer.leavesInView == leavesInView_) return;
    selection_.reset();  // until all chunks follow: an exception must not leave half of them behind
    for (auto& selected : selected_) selected = {};
    const auto leaves = layer.step->leaves();
    if (layer.selection->drawn.size() > leaves.size()) damaged("/leaves/node", leaves.size());
    for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) selectChunk(layer, leaves, chunk);
    selection_ = layer.selection;
    leavesInView_ = layer.leavesInView;
}

void StepPoints::selectChunk(const PointsPlan& layer, const storage::Leaves& leaves, std::size_t chunk) {
    const std::uint64_t begin = chunk * chunkPoints;
    const std::uint64_t size = std::min(chunkPoints, pointCount_ - begin);
    ChunkSelection& selected = selected_[chunk];
    selected.firstLeaf = leafAt(leaves, begin);
    const auto forEachLeaf = [&](auto visit) {
        for (std::size_t leaf = selected.firstLeaf;
             leaf < leaves.size() && leaves.pointBegin[leaf] < begin + size; ++leaf) {
            const auto [first, end] = within(leaves.pointBegin[leaf], layer.drawn(leaf), begin, size);
            visit(first, end);
        }
    };
    std::uint64_t drawn = 0;
    forEachLeaf([&](std::uint32_t first, std::uint32_t end) { drawn += end - first; });
    selected.listed = drawn <= size / 2;
    for (std::size_t leaf = selected.firstLeaf;
         !layer.selection->weights.empty() && leaf < leaves.size() && leaves.pointBegin[leaf] < begin + size;
         ++leaf) {
        const bool known = leaf < layer.selection->weights.size();
        selected.weights.push_back(known ? layer.selection->weightOf(leaf) : 0.0F);
    }
    if (selected.listed) {
        selected.numbers.reserve(drawn);
        forEachLeaf([&](std::uint32_t first, std::uint32_t end) {
            for (std::uint32_t i = first; i < end; ++i) selected.numbers.push_back(i);
        });
        return;
    }
    std::vector<std::uint32_t> drawnIn((size + blockPoints - 1) / blockPoints, 0);
    forEachLeaf([&](std::uint32_t first, std::uint32_t end) {
        selected.numbers.push_back(end);
        while (first < end) {
            const std::uint32_t block = first / blockPoints;
            const std::uint32_t next = std::min(end, (block + 1) * blockPoints);
            drawnIn[block] += next - first;
            first = next;
        }
    });
    for (std::uint32_t block = 0; block < drawnIn.size(); ++block) {
        if (drawnIn[block] == 0) continue;
        // The last block of the step may be short: its surplus invocations need the leaf to tell them so.
        auto& blocks = drawnIn[block] == blockPoints ? selected.wholeBlocks : selected.partBlocks;
        blocks.push_back(block);
    }
}

PointChunk& StepPoints::load(const storage::ParticleStep& step, std::size_t chunk) {
    ChunkSelection& selected = selected_[chunk];
    auto& resident = chunks_[chunk];
    if (!resident) {
        const std::uint64_t begin = chunk * chunkPoints;
        const std::uint64_t size = std::min(chunkPoints, pointCount_ - begin);
        const auto points = decode(step, begin, size, selected.firstLeaf);
        PointChunk made;
        made.points = GlBuffer::of(std::span<const DevicePoint>(points));
        made.pointsTexture = bufferTexture(made.points, GL_RGBA32UI);
        resident = std::move(made);
        selected.uploaded = false;
    }
    if (!selected.uploaded) {
        const std::size_t bytes = selected.numbers.size() * sizeof(std::uint32_t);
        if (resident->selected.bytes() < bytes) {
            resident->selected.grow(bytes);
            resident->selectedTexture = bufferTexture(resident->selected, GL_R32UI);
        }
        resident->selected.write(0, bytes, selected.numbers.data());
        if (!selected.weights.empty()) {
            resident->weights = GlBuffer::of(std::span<const float>(selected.weights));
            resident->weightsTexture = bufferTexture(resident->weights, GL_R32F);
        }
        selected.uploaded = true;
    }
    return *resident;
}

GlTexture volumeTexture(const glm::uvec3& size, const glm::vec2* cells) {
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_3D, 1, &name);
    GlTexture texture(name);
    const auto x = static_cast<GLsizei>(size.x), y = static_cast<GLsizei>(size.y),
               z = static_cast<GLsizei>(size.z);
    glTextureStorage3D(name, 1, GL_RG32F, x, y, z);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
        glTextureParameteri(name, axis, GL_CLAMP_TO_EDGE);
    }
    glTextureSubImage3D(name, 0, 0, 0, 0, x, y, z, GL_RG, GL_FLOAT, cells);
    return texture;
}

GridVolume::GridVolume(const StepVolume& grid)
    : size_(grid.size), brickCells_(std::max(2U, (std::max({size_.x, size_.y, size_.z}) + 31) / 32)) {
    std::vector<glm::vec2> cells;
    cells.reserve(grid.root.size());
    for (std::size_t i = 0; i < grid.root.size(); ++i) cells.emplace_back(grid.root[i], grid.t[i]);
    texture_ = volumeTexture(size_, cells.data());
    checkGl("a volume");
    const glm::uvec3 bricks = (size_ + brickCells_ - 1U) / brickCells_;
    for (std::uint32_t z = 0; z < bricks.z; ++z) {
        for (std::uint32_t y = 0; y < bricks.y; ++y) {
            for (std::uint32_t x = 0; x < bricks.x; ++x) {
                if (brickSeen(grid, {x, y, z})) visible_.push_back(x | y << 10 | z << 20);
            }
        }
    }
}

bool GridVolume::brickSeen(const StepVolume& grid, const glm::uvec3& brick) const {
    const auto x = reach(brick.x, brickCells_, size_.x), y = reach(brick.y, brickCells_, size_.y),
               z = reach(brick.z, brickCells_, size_.z);
    for (std::uint32_t k = z.begin; k < z.end; ++k) {
        for (std::uint32_t j = y.begin; j < y.end; ++j) {
            const float* const row = grid.root.data() + grid.index(0, j, k);
            if (std::any_of(row + x.begin, row + x.end, [](float root) { return root > 0.0F; })) return true;
        }
    }
    return false;
}

ResidentStep& ResidentSteps::of(const std::shared_ptr<const storage::ParticleStep>& step) {
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    for (auto& resident : steps_) {
        if (resident.key == step.get() && !resident.step.expired()) return resident;
    }
    return steps_.emplace_back(ResidentStep{.step = step, .key = step.get(), .points = StepPoints(*step)});
}

const PointChunk& ResidentSteps::chunk(ResidentStep& resident, std::size_t index) {
    const auto step = resident.step.lock();
    MOTE_CHECK(step != nullptr);
    const bool fresh = !resident.points.resident(index);
    PointChunk& chunk = resident.points.load(*step, index);
    chunk.lastUse = ++uses_;
    if (fresh) makeRoom();
    return chunk;
}

const GridVolume& ResidentSteps::volume(const std::shared_ptr<const StepVolume>& grid) {
    for (const auto& resident : volumes_) {
        if (resident.key == grid.get() && !resident.grid.expired()) return resident.volume;
    }
    return volumes_.emplace_back(ResidentVolume{grid, grid.get(), GridVolume(*grid)}).volume;
}

void ResidentSteps::dropExpired() {
    steps_.remove_if([](const ResidentStep& resident) { return resident.step.expired(); });
    volumes_.remove_if([](const ResidentVolume& resident) { return resident.grid.expired(); });
    makeRoom();
}

std::uint64_t ResidentSteps::bytes() const {
    std::uint64_t total = 0;
    for (const auto& resident : volumes_) total += resident.volume.bytes();
    for (const auto& resident : steps_) {
        for (std::size_t i = 0; i < resident.points.chunkCount(); ++i) {
            if (resident.points.resident(i)) total += resident.points.at(i)->bytes();
        }
    }
    return total;
}

void ResidentSteps::makeRoom() {
    // Volumes are small beside points and needed whole through a frame: only dropExpired() gives them up.
    for (std::uint64_t total = bytes(); total > budget_;) {
        ResidentStep* oldest = nullptr;
        std::size_t index = 0;
        std::uint64_t use = uses_;
        for (auto& resident : steps_) {
            for (std::size_t i = 0; i < resident.points.chunkCount(); ++i) {
                if (!resident.points.resident(i) || resident.points.at(i)->lastUse >= use) continue;
                oldest = &resident;
                index = i;
                use = resident.points.at(i)->lastUse;
            }
        }
        if (oldest == nullptr) return;
        total -= oldest->points.at(index)->bytes();
        oldest->points.evict(index);
    }
}

}  // namespace mote::render
