// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outputs of GPT (General Particle Tracer), GDF and text, as runs: a time or screen a step.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/table/held_source.h"
#include "preprocess/readers/text/byte_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "preprocess/readers/text/stored_number.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

/// A group of GPT's arrays, with its time or place.
struct GptBlock {
    std::optional<double> time;  ///< s
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;
};

// GDF, GPT's binary format: a header of 48 bytes, then blocks of a name (16 bytes), a type and a length, each
// with its data; blocks may open and close groups.
constexpr std::size_t headerBytes = 48;
constexpr std::size_t nameBytes = 16;
constexpr std::size_t blockBytes = nameBytes + 8;
constexpr std::size_t maxDepth = 64;

constexpr std::uint32_t typeMask = 0xff, opens = 0x100, closes = 0x200, single = 0x400, array = 0x800;

/// A type's code in the file.
struct GdfNumber {
    std::uint32_t code;
    StoredNumber type;
};
constexpr GdfNumber gdfNumbers[] = {{0x20, StoredNumber::uint8},   {0x30, StoredNumber::int8},
                                    {0x40, StoredNumber::uint16},  {0x50, StoredNumber::int16},
                                    {0x02, StoredNumber::int32},   {0x60, StoredNumber::uint32},
                                    {0x70, StoredNumber::uint64},  {0x80, StoredNumber::int64},
                                    {0x90, StoredNumber::float32}, {0x03, StoredNumber::float64}};

class GdfParser {
  public:
    GdfParser(std::string_view bytes, const std::string& name, HeldNumbers& held)
        : bytes_(bytes), name_(name), held_(held) {}

    Result<std::vector<GptBlock>> run() {
        if (bytes_.size() < headerBytes) return corrupt(0, "is cut short in its header");
        groups_.push_back({});
        for (std::size_t at = headerBytes; at < bytes_.size();) {
            // GPT ends a file that it was stopped at within a block.
            if (bytes_.size() - at < blockBytes) return corrupt(at, "is cut short in a block");
            const auto type = word(at + nameBytes), size = word(at + nameBytes + 4);
            const std::size_t data = at + blockBytes;
            if (size > bytes_.size() - data)
                return corrupt(at, "has a block of " + std::to_string(size) + " bytes, more than there are");
            const char* name = bytes_.data() + at;
            MOTE_RETURN_IF_ERROR(block(std::string(name, strnlen(name, nameBytes)), type, data, size));
            at = data + size;
        }
        while (!groups_.empty()) leave();
        return std::move(blocks_);
    }

  private:
    Error corrupt(std::size_t at, std::string message) const {
        return {ErrorCode::corrupt, name_ + ": byte " + std::to_string(at), std::move(message)};
    }

    std::uint32_t word(std::size_t at) const {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }

    Status block(const std::string& name, std::uint32_t type, std::size_t data, std::size_t size) {
        if ((type & closes) != 0) {
            if (groups_.size() > 1) leave();
            return success();
        }
        if ((type & opens) != 0) {
            if (groups_.size() > maxDepth) return corrupt(data, "has groups deeper than 64");
            groups_.push_back({});
        }
        const auto* const known =
            std::find_if(std::begin(gdfNumbers), std::end(gdfNumbers),
                         [&](const GdfNumber& number) { return number.code == (type & typeMask); });
        if (known == std::end(gdfNumbers)) return success();  // text and the like
        const std::size_t width = bytesOf(known->type);
        const auto number = [&](std::size_t i) {
            return loadStored<double>(bytes_.data() + data + i * width, known->type, false);
        };
        if ((type & single) != 0 && size >= width) {
            if (name == "time") groups_.back().time = number(0);
            return success();
        }
        if ((type & array) == 0) return success();
        if (size % width != 0) return corrupt(data, "has an array that ends within a number");
        MOTE_RETURN_IF_ERROR(held_.add(size / width, name_));
        std::vector<double> values(size / width);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(i);
        groups_.back().names.push_back(name);
        groups_.back().values.push_back(std::move(values));
        return success();
    }

    /// A group becomes a step where it has places.
    void leave() {
        GptBlock group = std::move(groups_.back());
        groups_.pop_back();
        const bool places = std::find(group.names.begin(), group.names.end(), "x") != group.names.end();
        if (places) blocks_.push_back(std::move(group));
    }

    std::string_view bytes_;
    const std::string& name_;
    HeldNumbers& held_;
    std::vector<GptBlock> groups_;  // those that are open, the root first
    std::vector<GptBlock> blocks_;
};

/// The groups of a GDF file that hold particles. Errors: corrupt, resourceExhausted, those of HeldFile::text.
Result<std::vector<GptBlock>> readGdf(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto bytes, file.text());
    const std::string name = file.name();
    return GdfParser(bytes, name, file.held).run();
}

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
    std::vector<std::size_t> unknown;
    for (std::size_t i = 0; i < block.names.size(); ++i) {
        std::string own = canonicalOfGpt(block.names[i], macro);
        const bool twice = std::find(table.names.begin(), table.names.end(), own) != table.names.end();
        if (own.empty())
            unknown.push_back(i);
        else if (!twice)
            table.add(std::move(own), std::move(block.values[i]));
    }
    for (const std::size_t i : unknown) table.addUnknown(block.names[i], std::move(block.values[i]));
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
