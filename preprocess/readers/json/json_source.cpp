// SPDX-License-Identifier: GPL-3.0-or-later
//
// JSON files of columns as runs: xsuite's particles, and others of named lists.
#include <algorithm>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/json/json_numbers.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/table/held_source.h"

namespace mote::prep {
namespace {

bool known(const std::string& name) {
    const auto meaning = tableMeaning(name, "");
    return !meaning || meaning->has_value();
}

/// An object as a table; nothing where its lists are no columns of particles.
std::optional<HeldTable> tableOf(JsonNumbers object, const std::string& name) {
    HeldTable table;
    table.where = name;
    std::size_t places = 0;
    for (auto& [key, list] : object.lists) {
        if (!known(key)) continue;
        if (key == "x" || key == "y" || key == "z" || key == "zeta" || key == "px") ++places;
        table.names.push_back(key);
        table.values.push_back(std::move(list));
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

}  // namespace

Result<std::unique_ptr<ParticleSource>> openJson(const std::vector<std::filesystem::path>& paths, double mass,
                                                 Progress& progress) {
    std::vector<HeldTable> tables;
    OddSteps odd;
    const bool series = paths.size() > 1;
    for (const std::filesystem::path& path : inOrder(paths)) {
        if (progress.cancelled()) return Error{ErrorCode::cancelled, "", "cancelled while a file was read"};
        const std::string name = path.filename().string();
        MOTE_ASSIGN_OR_RETURN(const auto text, readText(path));
        auto objects = JsonNumbers::parse(text, name);
        const std::size_t before = tables.size();
        if (objects) {
            for (JsonNumbers& object : *objects) {
                auto table = tableOf(std::move(object), name);
                if (table) tables.push_back(std::move(*table));
            }
        }
        if (series && tables.size() == before + 1) tables.back().iteration = fileNumber(path);
        Status status = objects ? success() : Status(objects.error());
        if (status.ok() && tables.size() == before) {
            status = Error{ErrorCode::unsupported, name,
                           "is JSON without lists x, px, y, py, zeta, delta, ... (as xsuite's "
                           "Particles.to_dict() writes)"};
        }
        MOTE_RETURN_IF_ERROR(odd.add(status));
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!tables.empty(), progress));
    return holdTables("json", std::move(tables), mass, progress);
}

}  // namespace mote::prep
