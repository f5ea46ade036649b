// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/gpt/gpt_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t gptMaxFields = 256;

using GptFields = std::array<std::string_view, gptMaxFields>;

/// GPT's names, in its own letter case, as those of a table. Its q is the charge of one particle, its rmacro
/// a radius; other arrays are of no use for a run.
std::string canonical(const std::string& name, bool macro) {
    static const std::map<std::string, std::string> names = {
        {"x", "x [m]"},     {"y", "y [m]"},   {"z", "z [m]"},      {"t", "t [s]"},     {"Bx", "vx [c]"},
        {"By", "vy [c]"},   {"Bz", "vz [c]"}, {"G", "gamma"},      {"GBx", "px [mc]"}, {"GBy", "py [mc]"},
        {"GBz", "pz [mc]"}, {"ID", "id"},     {"nmacro", "nmacro"}};
    const auto found = names.find(name);
    if (found != names.end()) return found->second;
    return name == "q" && !macro ? "q [C]" : "";
}

struct Parser {
    std::vector<GptBlock> blocks;
    GptBlock block;
    std::string waiting;  // the name of a number that stands in the next line

    void finish() {
        if (!block.values.empty() && !block.values.front().empty()) blocks.push_back(block);
        block = {};
    }

    Status line(std::string_view text, const std::string& where, HeldNumbers& held) {
        GptFields fields;
        const std::size_t count = splitFields(trim(text), ' ', fields);
        if (count == 0 || fields[0].front() == '#') return success();
        if (count > gptMaxFields) return Error{ErrorCode::unsupported, where, "has more than 256 columns"};
        const auto first = parseNumber(fields[0]);
        if (!waiting.empty() && count == 1 && first) {
            take(waiting, *first);
            waiting.clear();
            return success();
        }
        if (!first) return words(fields, count);
        if (count != block.names.size()) {
            return Error{ErrorCode::corrupt, where,
                         "has " + std::to_string(count) + " fields where " +
                             std::to_string(block.names.size()) + " are named"};
        }
        MOTE_RETURN_IF_ERROR(held.add(count, where));
        for (std::size_t i = 0; i < count; ++i) {
            const auto value = parseNumber(fields[i]);
            if (!value) {
                return Error{ErrorCode::corrupt, where + ", column " + block.names[i],
                             "'" + std::string(fields[i].substr(0, 40)) + "' is not a number"};
            }
            block.values[i].push_back(*value);
        }
        return success();
    }

  private:
    Status words(const GptFields& fields, std::size_t count) {
        const auto second = count == 2 ? parseNumber(fields[1]) : std::nullopt;
        if (second) {
            finish();
            take(std::string(fields[0]), *second);
        } else if (count == 1) {
            finish();
            waiting = std::string(fields[0]);
        } else {
            const auto time = block.time;
            finish();
            block.time = blocks.empty() || time ? time : std::nullopt;
            for (std::size_t i = 0; i < count; ++i) block.names.emplace_back(fields[i]);
            block.values.resize(count);
        }
        return success();
    }

    void take(const std::string& name, double value) {
        if (name == "time") block.time = value;
    }
};

}  // namespace

bool namesGptColumns(std::string_view line) {
    if (line.find_first_of(",;[({") != std::string_view::npos) return false;
    GptFields fields;
    const std::size_t count = std::min(splitFields(trim(line), ' ', fields), gptMaxFields);
    std::size_t known = 0;
    bool place = false;
    for (std::size_t i = 0; i < count; ++i) {
        place = place || fields[i] == "x";
        for (const char* name : {"Bx", "By", "Bz", "GBx", "GBy", "GBz", "G", "nmacro"}) {
            if (fields[i] == name) ++known;
        }
    }
    return place && known >= 2;
}

Result<std::vector<GptBlock>> readGptText(const std::filesystem::path& path, HeldNumbers& held) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    Parser parser;
    for (std::string_view line;;) {
        MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
        if (!more) break;
        MOTE_RETURN_IF_ERROR(
            parser.line(line, reader.name() + ": line " + std::to_string(reader.lineNumber()), held));
    }
    parser.finish();
    return std::move(parser.blocks);
}

HeldTable gptTable(GptBlock block, double mass, const std::string& name) {
    HeldTable table;
    table.where = name;
    table.time = block.time.value_or(0.0);
    const auto at = [&](const char* wanted) {
        return std::find(block.names.begin(), block.names.end(), wanted) - block.names.begin();
    };
    const auto count = static_cast<std::ptrdiff_t>(block.names.size());
    const bool macro = at("nmacro") < count;
    const auto masses = at("m");
    if (mass <= 0.0 && masses < count && !block.values[static_cast<std::size_t>(masses)].empty())
        mass = block.values[static_cast<std::size_t>(masses)].front() * massInEv;
    if (!(mass > 0.0) || !std::isfinite(mass)) {
        mass = electronMass;
        table.notes.emplace_back("the file names no mass: the particles are taken for electrons");
    }
    table.constants = {{TableQuantity::mass, mass}};
    for (std::size_t i = 0; i < block.names.size(); ++i) {
        std::string own = canonical(block.names[i], macro);
        const bool twice = std::find(table.names.begin(), table.names.end(), own) != table.names.end();
        if (own.empty() || twice) continue;
        table.names.push_back(std::move(own));
        table.values.push_back(std::move(block.values[i]));
    }
    return table;
}

}  // namespace mote::prep
