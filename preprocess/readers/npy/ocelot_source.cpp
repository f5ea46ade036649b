// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ocelot's particle arrays (.npz): rparticles (x, px/p0, y, py/p0, tau, (E - E0) / (p0 c)), q_array (C), E
// (GeV), s.
#include <algorithm>
#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/file_number.h"
#include "preprocess/readers/npy/npy_array.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/table/held_source.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t components = 6;
constexpr const char* names[components] = {"x [m]", "px [p0]", "y [m]", "py [p0]", "late [m]", "ptau"};

const NpyArray* find(const std::vector<NpyArray>& arrays, std::string_view name) {
    for (const NpyArray& array : arrays) {
        if (array.name == name && !array.header.structured()) return &array;
    }
    return nullptr;
}

/// The numbers of one row of an array [row, column], or of a plain list where `row` is 0.
Result<std::vector<double>> rowOf(const NpyArray& array, std::uint64_t row, std::uint64_t columns,
                                  HeldNumbers& held) {
    const NpyHeader& header = array.header;
    if (header.fields[0].kind == NpyField::other || header.fields[0].count != 1)
        return Error{ErrorCode::unsupported, array.part.where, "holds no integers, f4 or f8"};
    MOTE_RETURN_IF_ERROR(held.add(columns, array.part.where));
    const bool turned = header.fortranOrder && header.shape.size() == 2;
    const std::uint64_t step = turned ? header.itemBytes : header.itemBytes * columns;
    const std::uint64_t stride = turned ? header.itemBytes * components : header.itemBytes;
    std::vector<double> values(static_cast<std::size_t>(columns));
    MOTE_ASSIGN_OR_RETURN(auto reader,
                          NpyReader::open(array, {header.fields[0], header.dataOffset, stride, step}));
    const bool last = turned || row + 1 == components || header.shape.size() < 2;
    MOTE_RETURN_IF_ERROR(reader.read(row, 0, last && row + 1 >= header.shape.size(), std::span(values)));
    return values;
}

Result<HeldTable> tableOf(const std::filesystem::path& path, double mass, HeldNumbers& held) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(path));
    const std::string name = path.filename().string();
    const NpyArray* particles = find(arrays, "rparticles");
    const NpyArray* energy = find(arrays, "E");
    if (particles == nullptr || energy == nullptr)
        return Error{ErrorCode::unsupported, name, "has no arrays rparticles and E, as Ocelot writes them"};
    const auto& shape = particles->header.shape;
    if (shape.size() != 2 || shape[0] != components)
        return Error{ErrorCode::unsupported, particles->part.where, "is not of shape 6 x N"};
    HeldTable table;
    table.where = name;
    for (std::uint64_t i = 0; i < components; ++i) {
        table.names.emplace_back(names[i]);
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(*particles, i, shape[1], held));
        table.values.push_back(std::move(values));
    }
    const NpyArray* charges = find(arrays, "q_array");
    if (charges != nullptr && charges->header.shape == std::vector<std::uint64_t>{shape[1]}) {
        table.names.emplace_back("q [C]");
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(*charges, 0, shape[1], held));
        table.values.push_back(std::move(values));
    }
    MOTE_ASSIGN_OR_RETURN(const auto total, rowOf(*energy, 0, 1, held));
    if (mass <= 0.0) {
        mass = electronMass;
        table.notes.emplace_back("Ocelot names no mass: the particles are taken for electrons");
    }
    const double reference = total[0] * 1e9;
    if (!(reference > mass) || !std::isfinite(reference))
        return Error{ErrorCode::corrupt, energy->part.where,
                     "is no energy above the particles' mass, in GeV"};
    table.constants = {
        {TableQuantity::mass, mass},
        {TableQuantity::referenceMomentum, std::sqrt((reference - mass) * (reference + mass))}};
    return table;
}

}  // namespace

bool looksLikeOcelot(const std::filesystem::path& path) {
    const auto arrays = openNpyArrays(path);
    return arrays && find(*arrays, "rparticles") != nullptr && find(*arrays, "E") != nullptr;
}

Result<std::unique_ptr<ParticleSource>> openOcelot(const std::vector<std::filesystem::path>& paths,
                                                   double mass, Progress& progress) {
    std::vector<HeldTable> tables;
    HeldNumbers held;
    OddSteps odd;
    for (const std::filesystem::path& path : inOrder(paths)) {
        if (progress.cancelled()) return Error{ErrorCode::cancelled, "", "cancelled while a file was read"};
        auto table = tableOf(path, mass, held);
        MOTE_RETURN_IF_ERROR(odd.add(table ? success() : Status(table.error())));
        if (!table) continue;
        if (paths.size() > 1) table->iteration = fileNumber(path);
        tables.push_back(std::move(*table));
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!tables.empty(), progress));
    return holdTables("ocelot", std::move(tables), mass, progress);
}

}  // namespace mote::prep
