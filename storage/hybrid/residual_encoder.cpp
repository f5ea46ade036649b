// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/residual_encoder.h"

#include <openvdb/io/Compression.h>
#include <openvdb/io/io.h>
#include <openvdb/util/NodeMasks.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <tuple>
#include <utility>

#include "storage/hybrid/residual_file.h"
#include "storage/storage_error.h"
#include "storage/vdb/vdb_file.h"

namespace mote::storage {
namespace {

using Mask = openvdb::util::NodeMask<3>;
static_assert(Mask::SIZE == residualBrickSamples);
static_assert(openvdb::OPENVDB_FILE_VERSION == residualFileVersion);  // else residual_reader.h must learn it

using Scratches = std::span<const std::unique_ptr<ScratchFile>>;
static_assert(vdbLeafSide == residualBrickSide && vdbNodeSide == residualNodeBricks * residualBrickSide);

/// Nodes of a top node, a side, and the masks of what lies in each.
constexpr std::uint32_t topNodes = vdbTopSide / vdbNodeSide;
using NodeMask = openvdb::util::NodeMask<4>;
using TopMask = openvdb::util::NodeMask<5>;
static_assert(NodeMask::DIM == residualNodeBricks && TopMask::DIM == topNodes);

GridSize topOf(const GridSize& node) {
    return {node[0] / topNodes, node[1] / topNodes, node[2] / topNodes};
}

std::uint32_t placeInTop(const GridSize& node) {
    return (node[0] % topNodes * topNodes + node[1] % topNodes) * topNodes + node[2] % topNodes;
}

auto orderInFile(const ResidualPart& part) {
    return std::tuple(topOf(part.node), placeInTop(part.node), part.scratch, part.offset);
}

template <class T>
void put(std::ostream& out, const T& value) {
    out.write(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// A node's masks and the values that it has itself: none.
template <class Mask>
void putOwn(std::ostream& out, const Mask& children, bool halves) {
    children.save(out);
    const Mask none;
    none.save(out);
    std::vector<float> values(Mask::SIZE, 0.0F);
    openvdb::io::writeCompressedValues(out, values.data(), Mask::SIZE, none, children, halves);
}

/// The bricks of a node, from all of its parts, in the order of the file.
class NodeBricks {
  public:
    struct Brick {
        std::uint32_t place;
        std::span<const char> bytes;
    };
    NodeBricks(std::span<const ResidualPart> parts, Scratches scratches) {
        bytes_.reserve(parts.size());
        for (const auto& part : parts) read(part, *scratches[part.scratch]);
        std::sort(bricks_.begin(), bricks_.end(),
                  [](const Brick& a, const Brick& b) { return a.place < b.place; });
    }
    const std::vector<Brick>& bricks() const { return bricks_; }

  private:
    void read(const ResidualPart& part, const ScratchFile& scratch) {
        auto& bytes = bytes_.emplace_back(part.bytes);
        const auto got = scratch.read(part.offset, std::as_writable_bytes(std::span(bytes)));
        if (!got.ok()) throw StorageError(got.error());
        std::vector<EncodedBrick> heads(part.bricks);
        const auto headBytes = std::as_writable_bytes(std::span(heads));
        std::copy_n(std::as_bytes(std::span(bytes)).begin(), headBytes.size(), headBytes.begin());
        auto rest = std::span<const char>(bytes).subspan(headBytes.size());
        for (const auto& head : heads) {
            bricks_.push_back({head.place, rest.first(head.bytes)});
            rest = rest.subspan(head.bytes);
        }
    }

    std::vector<std::vector<char>> bytes_;
    std::vector<Brick> bricks_;
};

/// Writes the tree of all parts, which is not in memory, in the order of OpenVDB's own trees
/// (tree/RootNode.h, InternalNode.h, LeafNode.h, version 10).
class PartsTree {
  public:
    PartsTree(std::vector<ResidualPart> parts, Scratches scratches, bool halves)
        : parts_(std::move(parts)), scratches_(scratches), halves_(halves) {
        std::sort(parts_.begin(), parts_.end(),
                  [](const auto& a, const auto& b) { return orderInFile(a) < orderInFile(b); });
    }

    void writeTopology(std::ostream& out) const {
        put(out, std::int32_t{1});  // buffers a leaf
        put(out, background_);
        openvdb::io::setGridBackgroundValuePtr(out, &background_);
        std::uint32_t tops = 0;
        eachTop([&](std::span<const ResidualPart>) { ++tops; });
        put(out, std::uint32_t{0});  // tiles
        put(out, tops);
        eachTop([&](std::span<const ResidualPart> top) { putTop(out, top); });
    }

    void writeValues(std::ostream& out) const {
        eachNode(parts_, [&](std::span<const ResidualPart> parts) {
            const NodeBricks node(parts, scratches_);
            for (const auto& brick : node.bricks()) {
                out.write(brick.bytes.data(), static_cast<std::streamsize>(brick.bytes.size()));
            }
        });
    }

  private:
    using Parts = std::span<const ResidualPart>;

    template <class Key, class Visit>
    static void eachRun(Parts parts, const Key& key, const Visit& visit) {
        while (!parts.empty()) {
            std::size_t count = 1;
            while (count < parts.size() && key(parts[count]) == key(parts[0])) ++count;
            visit(parts.first(count));
            parts = parts.subspan(count);
        }
    }
    template <class Visit>
    void eachTop(const Visit& visit) const {
        eachRun(
            parts_, [](const ResidualPart& part) { return topOf(part.node); }, visit);
    }
    template <class Visit>
    static void eachNode(Parts parts, const Visit& visit) {
        eachRun(
            parts, [](const ResidualPart& part) { return part.node; }, visit);
    }

    void putTop(std::ostream& out, Parts top) const {
        for (const auto index : topOf(top[0].node)) put(out, static_cast<std::int32_t>(index * vdbTopSide));
        TopMask children;
        eachNode(top, [&](Parts node) { children.setOn(placeInTop(node[0].node)); });
        putOwn(out, children, halves_);
        eachNode(top, [&](Parts node) { putNode(out, NodeBricks(node, scratches_)); });
    }

    void putNode(std::ostream& out, const NodeBricks& node) const {
        NodeMask children;
        for (const auto& brick : node.bricks()) children.setOn(brick.place);
        putOwn(out, children, halves_);
        for (const auto& brick : node.bricks()) out.write(brick.bytes.data(), residualBrickSamples / 8);
    }

    std::vector<ResidualPart> parts_;
    Scratches scratches_;
    bool halves_;
    float background_ = 0.0F;
};

/// Without parts, an empty box as OpenVDB has it: from the greatest number to the least.
void noteSamples(std::span<const ResidualPart> parts, const FloatGrid& grid) {
    using Limits = std::numeric_limits<int>;
    std::int64_t samples = 0;
    FloatGrid::Indices first, last;
    first.fill(Limits::max());
    last.fill(Limits::min());
    for (const auto& part : parts) {
        samples += static_cast<std::int64_t>(part.samples);
        for (std::size_t a = 0; a < 3; ++a) {
            first[a] = std::min(first[a], static_cast<int>(part.begin[a]));
            last[a] = std::max(last[a], static_cast<int>(part.end[a]) - 1);
        }
    }
    grid.noteSamples(first, last, samples);
}

}  // namespace

/// Told what OpenVDB tells a file's.
struct ResidualEncoder::Stream {
    std::ostringstream text;
    Stream() {
        openvdb::io::setDataCompression(text, vdbCompression(VdbValues::plain));
        openvdb::io::setGridBackgroundValuePtr(text, &background);
    }
    float background = 0.0F;
};

/// Halves have 11 bits, so a value is off by at most greatest * step / 2048, less than half a step, and must
/// be a normal number.
bool fitHalves(double greatest, double step) {
    return greatest < 1000.0 && greatest * step <= 65504.0 && step >= 0x1p-14;
}

ResidualEncoder::ResidualEncoder(const ResidualCoding& coding, const GridSize& node)
    : coding_(coding), stream_(std::make_unique<Stream>()) {
    MOTE_CHECK(coding.step > 0.0);
    part_.node = node;
    part_.begin = coding.size;
}

ResidualEncoder::~ResidualEncoder() = default;

void ResidualEncoder::add(const GridSize& brick,
                          std::span<const std::int32_t, residualBrickSamples> multiples) {
    Mask mask;
    std::array<float, residualBrickSamples> values{};
    for (std::uint32_t i = 0; i < residualBrickSamples; ++i) {
        if (multiples[i] == 0) continue;
        MOTE_CHECK(std::abs(multiples[i]) <= maxResidualMultiple);
        values[offsetInBrick(i)] = static_cast<float>(multiples[i] * coding_.step);
        mask.setOn(offsetInBrick(i));
        const GridSize in{i & 7U, i >> 3U & 7U, i >> 6U};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto at = brick[a] * residualBrickSide + in[a];
            part_.begin[a] = std::min(part_.begin[a], at);
            part_.end[a] = std::max(part_.end[a], at + 1);
        }
    }
    if (mask.isOff()) return;
    stream_->text.str({});
    mask.save(stream_->text);
    openvdb::io::writeCompressedValues(stream_->text, values.data(), Mask::SIZE, mask, Mask(),
                                       coding_.halves);
    const auto encoded = stream_->text.view();
    bytes_.insert(bytes_.end(), encoded.begin(), encoded.end());
    constexpr auto side = residualNodeBricks;
    const auto place = (brick[0] % side * side + brick[1] % side) * side + brick[2] % side;
    bricks_.push_back({place, static_cast<std::uint32_t>(encoded.size())});
    ++part_.bricks;
    part_.samples += mask.countOn();
}

Result<std::optional<ResidualPart>> ResidualEncoder::store(ScratchFile& scratch) const {
    if (bricks_.empty()) return std::optional<ResidualPart>();
    std::vector<std::byte> all;
    const auto append = [&](std::span<const std::byte> bytes) {
        all.insert(all.end(), bytes.begin(), bytes.end());
    };
    append(std::as_bytes(std::span(bricks_)));
    append(std::as_bytes(std::span(bytes_)));
    MOTE_ASSIGN_OR_RETURN(const auto at, scratch.append(all));
    auto part = part_;
    part.offset = at;
    part.bytes = all.size();
    return std::optional(part);
}

Status writeResidual(const std::filesystem::path& path, const ResidualCoding& coding,
                     const std::vector<ResidualPart>& parts, Scratches scratches) {
    const PartsTree tree(parts, scratches, coding.halves);
    const FloatGrid grid(
        residualGridName, coding.errorToWorld,
        {[&](auto& out) { tree.writeTopology(out); }, [&](auto& out) { tree.writeValues(out); }});
    grid.setHalves(coding.halves);
    grid.note(residualStepName, coding.step);
    noteSamples(parts, grid);
    return writeVdbFile(path, {grid}, VdbValues::plain);
}

}  // namespace mote::storage
