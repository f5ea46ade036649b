// SPDX-License-Identifier: GPL-3.0-or-later
//
// JSON files of columns as runs: xsuite's particles, and others of named lists.
#include "preprocess/readers/json/json_numbers.h"
#include "preprocess/readers/table/held_source.h"

namespace mote::prep {
namespace {

bool isQuantity(const std::string& name) {
    const auto meaning = tableMeaning(name, "");
    return !meaning || meaning->has_value();
}

/// An object as a table; nothing where its lists are no columns of particles.
std::optional<HeldTable> tableOfJson(JsonNumbers object, const std::string& name) {
    HeldTable table;
    table.where = name;
    std::size_t places = 0;
    for (auto& [key, list] : object.lists) {
        if (!isQuantity(key)) continue;
        if (key == "x" || key == "y" || key == "z" || key == "zeta" || key == "px") ++places;
        table.add(key, std::move(list));
    }
    if (places < 2) return std::nullopt;
    for (const auto& [key, value] : object.numbers) {
        const auto meaning = tableMeaning(key, "");
        if (!meaning || !meaning->has_value()) continue;
        const TableMeaning& it = **meaning;
        // A single number beside lists says something of all rows: a mass, a momentum, a weight.
        if (it.relative || it.inMass || it.quantity == TableQuantity::id) continue;
        table.constants.push_back({it.quantity, value * it.factor});
    }
    return table;
}

Result<std::vector<HeldTable>> tablesOfJson(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto text, file.text());
    MOTE_ASSIGN_OR_RETURN(auto objects, JsonNumbers::parse(text, file.name()));
    std::vector<HeldTable> tables;
    for (JsonNumbers& object : objects) {
        if (auto table = tableOfJson(std::move(object), file.name())) tables.push_back(std::move(*table));
    }
    if (!tables.empty()) return tables;
    return unsupported(
        file.name(),
        "is JSON without lists x, px, y, py, zeta, delta, ... (as xsuite's Particles.to_dict() writes)");
}

}  // namespace

extern const ParticleReader jsonReader;
constinit const ParticleReader jsonReader{
    "json", "JSON with lists of numbers", ParticleReader::Kind::text,
    [](const AskedFile& file) -> Result<bool> {
        return file.words().starts_with('{') || file.words().starts_with('[');
    },
    [](const AskedRun& run, Progress& progress) { return openHeld("json", tablesOfJson, run, progress); }};

}  // namespace mote::prep
