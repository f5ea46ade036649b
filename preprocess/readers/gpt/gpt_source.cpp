// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outputs of GPT (General Particle Tracer), GDF and text, as runs: a time or screen a step.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/gpt/gdf_file.h"
#include "preprocess/readers/text/byte_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t gptMaxFields = 256;
constexpr std::uint64_t linesToLookAt = 100;

using GptFields = std::array<std::string_view, gptMaxFields>;

/// GPT's names, in its own letter case, as those of a table. Its q is the charge of one particle, its rmacro
/// a radius; other arrays are of no use for a run.
std::string canonicalOfGpt(const std::string& name, bool macro) {
    static const std::map<std::string, std::string> names = {
        {"x", "x [m]"},     {"y", "y [m]"},   {"z", "z [m]"},      {"t", "t [s]"},     {"Bx", "vx [c]"},
        {"By", "vy [c]"},   {"Bz", "vz [c]"}, {"G", "gamma"},      {"GBx", "px [mc]"}, {"GBy", "py [mc]"},
        {"GBz", "pz [mc]"}, {"ID", "id"},     {"nmacro", "nmacro"}};
    const auto found = names.find(name);
    if (found != names.end()) return found->second;
    return name == "q" && !macro ? "q [C]" : "";
}

struct GptTextParser {
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
        if (count > gptMaxFields) return unsupported(where, "has more than 256 columns");
        const auto first = parseNumber(fields[0]);
        if (!waiting.empty() && count == 1 && first) {
            take(waiting, *first);
            waiting.clear();
            return success();
        }
        if (!first) return words(fields, count);
        if (count != block.names.size()) {
            return corrupt(where, "has " + std::to_string(count) + " fields where " +
                                      std::to_string(block.names.size()) + " are named");
        }
        MOTE_RETURN_IF_ERROR(held.add(count, where));
        for (std::size_t i = 0; i < count; ++i) {
            const auto value = parseNumber(fields[i]);
            if (!value) return noNumber(fields[i], where, block.names[i]);
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

/// x and at least two of GPT's own.
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

/// The blocks of a text: lines "time 1e-9", lines of names, rows.
Result<std::vector<GptBlock>> readGptText(const HeldFile& file) {
    GptTextParser parser;
    MOTE_RETURN_IF_ERROR(
        eachLine(file.path, file.progress, [&](std::string_view line, const std::string& where) {
            return parser.line(line, where, file.held);
        }));
    parser.finish();
    return std::move(parser.blocks);
}

/// GPT's names as a table's: Bx, GBx, G, m [kg], q of one particle, nmacro. The mass is the job's, else that
/// of the first row.
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
    table.setMass(std::isfinite(mass) ? mass : 0.0, "the file names");
    for (std::size_t i = 0; i < block.names.size(); ++i) {
        std::string own = canonicalOfGpt(block.names[i], macro);
        const bool twice = std::find(table.names.begin(), table.names.end(), own) != table.names.end();
        if (own.empty() || twice) continue;
        table.add(std::move(own), std::move(block.values[i]));
    }
    return table;
}

constexpr std::string_view gdfMagic = "\x75\x4c\x9f\x05";  // 94325877

Result<std::vector<HeldTable>> tablesOfGpt(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto begin, beginningOf(file.path, gdfMagic.size()));
    MOTE_ASSIGN_OR_RETURN(auto blocks, begin == gdfMagic ? readGdf(file) : readGptText(file));
    if (blocks.empty()) return notFound(file.name(), "holds no particles (arrays x, Bx or GBx, ...)");
    std::vector<HeldTable> tables;
    for (GptBlock& block : blocks) tables.push_back(gptTable(std::move(block), file.mass, file.name()));
    return tables;
}

Result<std::unique_ptr<ParticleSource>> openGpt(const AskedRun& run, Progress& progress) {
    return openHeld("gpt", tablesOfGpt, run, progress);
}

/// Whether one of the first lines names GPT's columns.
Result<bool> tellsGptText(const AskedFile& file) {
    auto reader = LineReader::open(file.path);
    for (std::string_view line; reader && reader->lineNumber() < linesToLookAt;) {
        const auto more = reader->next(line);
        if (!more || !*more) return false;
        if (namesGptColumns(line)) return true;
    }
    return false;
}

constexpr std::string_view gptTold = "GPT's mark, or its names in text";

}  // namespace

extern const ParticleReader gdfReader;
constinit const ParticleReader gdfReader{
    "gpt", gptTold, ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return file.begin.starts_with(gdfMagic); }, openGpt};
extern const ParticleReader gptTextReader;
constinit const ParticleReader gptTextReader{"gpt", gptTold, ParticleReader::Kind::text, tellsGptText,
                                             openGpt};

}  // namespace mote::prep
