// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/step_writer.h"

#include <fmt/format.h>

#include "protocol/scene/json.h"
#include "storage/files/write_file.h"
#include "storage/particles/step_file.h"

namespace mote::storage {
namespace {

StepShape shapeOf(const StepContent& content) {
    return {content.nodes.size(), content.leaves.size(), content.rows.size(), content.previewPoints.size(),
            content.volumeSize};
}

Status writeArrays(const StepFile& file, const StepContent& content) {
    const auto write = [&](StepArray which, auto values) {
        return file.write(which, 0, std::as_bytes(values));
    };
    const auto& nodes = content.nodes;
    const auto& leaves = content.leaves;
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeLevel, nodes.level));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeMorton, nodes.morton));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeFirstChild, nodes.firstChild));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeChildCount, nodes.childCount));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeCount, nodes.count));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeDensity, nodes.density));
    MOTE_RETURN_IF_ERROR(write(StepArray::octreeMinDensity, nodes.minDensity));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafNode, leaves.node));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafPointBegin, leaves.pointBegin));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafPointCount, leaves.pointCount));
    MOTE_RETURN_IF_ERROR(write(StepArray::leafDensity, leaves.density));
    MOTE_RETURN_IF_ERROR(write(StepArray::pointPosition, content.positions));
    MOTE_RETURN_IF_ERROR(write(StepArray::pointRow, content.rows));
    MOTE_RETURN_IF_ERROR(write(StepArray::volumeDensity, content.volume));
    MOTE_RETURN_IF_ERROR(write(StepArray::previewPoint, content.previewPoints));
    return write(StepArray::previewThreshold, content.previewThreshold);
}

}  // namespace

Status writeStep(const std::filesystem::path& directory, const std::string& name,
                 const StepContent& content) {
    const auto shape = shapeOf(content);
    MOTE_ASSIGN_OR_RETURN(const auto file, StepFile::create(directory / (name + ".h5"), shape, content));
    MOTE_RETURN_IF_ERROR(writeArrays(file, content));
    MOTE_ASSIGN_OR_RETURN(const auto blocks, file.hashBlocks(0, file.blockCount()));
    return writeNewFile(directory / (name + ".digest"), toJson(file.digest(shape, blocks)));
}

std::string stepName(std::uint32_t step) {
    return fmt::format("step-{:06}", step);
}

}  // namespace mote::storage
