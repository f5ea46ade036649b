// SPDX-License-Identifier: GPL-3.0-or-later
//
// Archives whose momenta are in units of a reference momentum (numpy.savez of xsuite's Particles.to_dict()):
// read whole, as a table.
#include <algorithm>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/npy/npy_array.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/table/held_source.h"

namespace mote::prep {
namespace {

bool isNumber(const NpyArray& array) {
    return !array.header.structured() && array.header.fields[0].kind != NpyField::other &&
           array.header.fields[0].count == 1;
}

Result<std::vector<double>> valuesOf(const NpyArray& array, HeldNumbers& held) {
    const std::uint64_t count = array.header.shape.empty() ? 1 : array.header.shape[0];
    MOTE_RETURN_IF_ERROR(held.add(count, array.part.where));
    std::vector<double> values(static_cast<std::size_t>(count));
    MOTE_ASSIGN_OR_RETURN(
        auto reader,
        NpyReader::open(array, {array.header.fields[0], array.header.dataOffset, array.header.itemBytes, 0}));
    MOTE_RETURN_IF_ERROR(reader.read(0, 0, true, std::span(values)));
    return values;
}

Result<HeldTable> tableOf(const std::filesystem::path& path, HeldNumbers& held) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(path));
    HeldTable table;
    table.where = path.filename().string();
    for (const NpyArray& array : arrays) {
        const auto meaning = tableMeaning(array.name, array.part.where);
        if (!meaning) return meaning.error();
        if (!meaning->has_value() || !isNumber(array) || array.header.shape.size() > 1) continue;
        MOTE_ASSIGN_OR_RETURN(auto values, valuesOf(array, held));
        if (array.header.shape.empty()) {
            table.constants.push_back({(*meaning)->quantity, values[0] * (*meaning)->factor});
            continue;
        }
        table.names.push_back(array.name);
        table.values.push_back(std::move(values));
    }
    return table;
}

}  // namespace

bool looksLikeScaledNpz(const std::filesystem::path& path) {
    const auto arrays = openNpyArrays(path);
    return arrays && std::any_of(arrays->begin(), arrays->end(),
                                 [](const NpyArray& array) { return array.name == "p0c"; });
}

Result<std::unique_ptr<ParticleSource>> openScaledNpz(const std::vector<std::filesystem::path>& paths,
                                                      double mass, Progress& progress) {
    std::vector<HeldTable> tables;
    HeldNumbers held;
    OddSteps odd;
    for (const std::filesystem::path& path : inOrder(paths)) {
        if (progress.cancelled()) return Error{ErrorCode::cancelled, "", "cancelled while a file was read"};
        auto table = tableOf(path, held);
        MOTE_RETURN_IF_ERROR(odd.add(table ? success() : Status(table.error())));
        if (!table) continue;
        if (paths.size() > 1) table->iteration = fileNumber(path);
        tables.push_back(std::move(*table));
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!tables.empty(), progress));
    return holdTables("npz", std::move(tables), mass, progress);
}

}  // namespace mote::prep
