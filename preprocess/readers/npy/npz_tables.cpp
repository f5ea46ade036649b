// SPDX-License-Identifier: GPL-3.0-or-later
//
// Archives of NumPy arrays as tables: those in units of p0c, and Ocelot's particle arrays: rparticles (x,
// px/p0, y, py/p0, tau, (E - E0) / (p0 c)), q_array (C), E (GeV), s.
#include "preprocess/readers/npy/npz_tables.h"

#include <algorithm>
#include <cmath>

#include "preprocess/readers/npy/npy_array.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/readers/table/held_source.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t components = 6;
constexpr const char* componentNames[components] = {"x [m]",   "px [p0]",  "y [m]",
                                                    "py [p0]", "late [m]", "ptau"};

const NpyArray* arrayNamed(const std::vector<NpyArray>& arrays, std::string_view name) {
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
        return unsupported(array.part.where, "holds no integers, f4 or f8");
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

Result<HeldTable> tableOfScaledNpz(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(file.path));
    HeldTable table;
    table.where = file.name();
    for (const NpyArray& array : arrays) {
        const NpyHeader& header = array.header;
        MOTE_ASSIGN_OR_RETURN(const auto meaning, tableMeaning(array.name, array.part.where));
        const bool numbers = !header.structured() && header.fields[0].kind != NpyField::other &&
                             header.fields[0].count == 1 && header.shape.size() < 2;
        if (!meaning || !numbers) continue;
        const bool list = !header.shape.empty();
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(array, 0, list ? header.shape[0] : 1, file.held));
        if (list)
            table.add(array.name, std::move(values));
        else
            table.constants.push_back({meaning->quantity, values[0] * meaning->factor});
    }
    return table;
}

Result<HeldTable> tableOfOcelot(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(file.path));
    const NpyArray* particles = arrayNamed(arrays, "rparticles");
    const NpyArray* energy = arrayNamed(arrays, "E");
    if (particles == nullptr || energy == nullptr)
        return unsupported(file.name(), "has no arrays rparticles and E, as Ocelot writes them");
    const auto& shape = particles->header.shape;
    if (shape.size() != 2 || shape[0] != components)
        return unsupported(particles->part.where, "is not of shape 6 x N");
    HeldTable table;
    table.where = file.name();
    for (std::uint64_t i = 0; i < components; ++i) {
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(*particles, i, shape[1], file.held));
        table.add(componentNames[i], std::move(values));
    }
    const NpyArray* charges = arrayNamed(arrays, "q_array");
    if (charges != nullptr && charges->header.shape == std::vector<std::uint64_t>{shape[1]}) {
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(*charges, 0, shape[1], file.held));
        table.add("q [C]", std::move(values));
    }
    MOTE_ASSIGN_OR_RETURN(const auto total, rowOf(*energy, 0, 1, file.held));
    const double mass = table.setMass(file.mass, "Ocelot names");
    const double reference = total[0] * 1e9;
    if (!(reference > mass) || !std::isfinite(reference))
        return corrupt(energy->part.where, "is no energy above the particles' mass, in GeV");
    table.constants.push_back(
        {TableQuantity::referenceMomentum, std::sqrt((reference - mass) * (reference + mass))});
    return table;
}

}  // namespace

bool isScaledNpz(const std::filesystem::path& path) {
    const auto arrays = openNpyArrays(path);
    return arrays && std::any_of(arrays->begin(), arrays->end(),
                                 [](const NpyArray& array) { return array.name == "p0c"; });
}

Result<std::unique_ptr<ParticleSource>> openScaledNpz(const AskedRun& run, Progress& progress) {
    return openHeld("npz", tableOfScaledNpz, run, progress);
}

extern const ParticleReader ocelotReader;
constinit const ParticleReader ocelotReader{
    "ocelot", "an archive with the arrays rparticles and E", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> {
        if (!looksLikeZip(file.begin)) return false;
        const auto arrays = openNpyArrays(file.path);
        return arrays && arrayNamed(*arrays, "rparticles") != nullptr && arrayNamed(*arrays, "E") != nullptr;
    },
    [](const AskedRun& run, Progress& progress) { return openHeld("ocelot", tableOfOcelot, run, progress); }};

}  // namespace mote::prep
