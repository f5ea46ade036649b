// SPDX-License-Identifier: GPL-3.0-or-later
//
// Distributions of OPAL in text: what it reads (FROMFILE: the number of rows, perhaps names, then six
// numbers a row) and what it writes at its start (WRITETOFILE: names with units in a comment).
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "preprocess/readers/table/held_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "preprocess/readers/unit_names.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

constexpr std::size_t columns = 6, longitudinal = 4, opalMaxFields = 16;
// Of no beam that OPAL is used for: 5 TeV electrons. What is greater is in eV.
constexpr double greatestBetaGamma = 1e7;
// A bunch is longer than that in m, and its emission shorter in s.
constexpr double longestEmission = 1e-8;

constexpr std::string_view noteOfTime =
    "the fifth column, which is never more than 1e-8, is taken for the time of emission in s";
constexpr std::string_view noteOfPlace = "the fifth column is taken for z in m";

using OpalFields = std::array<std::string_view, opalMaxFields>;

std::string_view commentOf(std::string_view line) {
    line = trim(line);
    return line.starts_with('#') ? trim(line.substr(1)) : std::string_view();
}

/// The comment over what OPAL writes: "x [m] px [betax gamma] ...".
bool isDumpHead(std::string_view line) {
    const std::string text = lower(commentOf(line));
    return text.starts_with("x [m]") && text.find("[betax gamma]") != std::string::npos;
}

bool isWord(std::string_view field, std::string_view word) {
    return lower(field) == word;
}

/// "x px y py z pz", with t in place of z where particles are emitted.
bool isNames(const OpalFields& fields, std::size_t count) {
    static constexpr std::array<std::string_view, columns> names{"x", "px", "y", "py", "z", "pz"};
    if (count < columns) return false;
    for (std::size_t i = 0; i < columns; ++i) {
        const bool time = i == longitudinal && isWord(fields[i], "t");
        if (!time && !isWord(fields[i], names[i])) return false;
    }
    return true;
}

/// One file, row by row.
class OpalParser {
  public:
    OpalParser(HeldTable& table, HeldNumbers& held) : table_(table), held_(held) {
        table_.values.resize(columns);
    }

    Status line(std::string_view text, const std::string& where) {
        if (const auto comment = commentOf(text); !comment.empty() || trim(text).starts_with('#')) {
            if (isDumpHead(text)) {
                names_ = true;
                emitted_ = lower(comment).find("t [s]") != std::string::npos;
            }
            return success();
        }
        const std::size_t count = splitFields(trim(text), ' ', fields_);
        if (count == 0 || fields_[0].empty()) return success();
        if (count == 1 && !declared_ && table_.values[0].empty()) return takeCount(where);
        if (!names_ && table_.values[0].empty() && isNames(fields_, count)) {
            names_ = true;
            emitted_ = isWord(fields_[longitudinal], "t");
            return success();
        }
        return row(count, where);
    }

    Status finish() {
        const std::uint64_t rows = table_.values[0].size();
        if (declared_ && *declared_ != rows) {
            return corrupt(table_.where, "declares " + std::to_string(*declared_) + " particles and has " +
                                             std::to_string(rows));
        }
        if (!declared_ && !names_) {
            return unsupported(
                table_.where,
                "is no distribution of OPAL: it neither begins with the number of its rows nor "
                "names x, px, y, py, z, pz");
        }
        for (const std::size_t i : {std::size_t{1}, std::size_t{3}, std::size_t{5}}) {
            if (greatest(i) <= greatestBetaGamma) continue;
            return unsupported(
                table_.where,
                "has momenta beyond 1e7, which are no beta gamma; say what they are with --map "
                "(x=1 [m],px=2 [eV/c],y=3 [m],py=4 [eV/c],z=5 [m],pz=6 [eV/c])");
        }
        name();
        return success();
    }

  private:
    Status takeCount(const std::string& where) {
        declared_ = parseId(fields_[0]);
        return declared_ ? success() : Status(corrupt(where, "is no number of particles"));
    }

    Status row(std::size_t count, const std::string& where) {
        if (count < columns) {
            return corrupt(where, "has " + std::to_string(count) + " fields where six or more belong");
        }
        MOTE_RETURN_IF_ERROR(held_.add(columns, where));
        for (std::size_t i = 0; i < columns; ++i) {
            const auto value = parseNumber(fields_[i]);
            if (!value) return noNumber(fields_[i], where, std::to_string(i + 1));
            table_.values[i].push_back(*value);
        }
        return success();
    }

    double greatest(std::size_t column) const {
        double most = 0.0;
        for (const double value : table_.values[column]) most = std::max(most, std::abs(value));
        return most;
    }

    void name() {
        if (!names_) {
            emitted_ = !table_.values[0].empty() && greatest(longitudinal) <= longestEmission;
            table_.notes.emplace_back(emitted_ ? noteOfTime : noteOfPlace);
        }
        table_.names = {"x [m]", "px [mc]", "y [m]", "py [mc]", emitted_ ? "t [s]" : "z [m]", "pz [mc]"};
        table_.notes.emplace_back(
            "momenta are taken as beta gamma, OPAL's own; of a file for INPUTMOUNITS = EV say so with --map");
    }

    HeldTable& table_;
    HeldNumbers& held_;
    OpalFields fields_;
    std::optional<std::uint64_t> declared_;
    bool names_ = false, emitted_ = false;
};

Result<HeldTable> tableOfOpal(const HeldFile& file) {
    HeldTable table;
    table.where = file.name();
    OpalParser parser(table, file.held);
    MOTE_RETURN_IF_ERROR(parseLines(file, parser));
    MOTE_RETURN_IF_ERROR(parser.finish());
    table.setMass(file.mass, "the file names");
    return table;
}

Result<std::unique_ptr<ParticleSource>> openOpal(const AskedRun& run, Progress& progress) {
    return openHeld("opal", tableOfOpal, run, progress);
}

/// A text that begins as one with names: what has none is a table of numbers like others.
Result<bool> tellsOpal(const AskedFile& file) {
    const std::size_t end = file.begin.find('\n');
    const std::string_view first = trim(file.begin.substr(0, end));
    if (isDumpHead(first)) return true;
    if (!parseId(first) || end == std::string_view::npos) return false;
    const std::string_view second = file.begin.substr(end + 1);
    OpalFields fields;
    const std::size_t count = splitFields(trim(second.substr(0, second.find('\n'))), ' ', fields);
    return isNames(fields, count);
}

/// OPAL's and IMPACT-T's look alike, and mean the same but for the fifth column and the charge.
Result<bool> tellsOpalRows(const AskedFile& file) {
    return file.shape.numbers && file.shape.columns == columns && file.shape.declared.has_value();
}

constexpr std::string_view opalTold = "its first line the number of rows of six numbers";

}  // namespace

extern const ParticleReader opalReader;
constinit const ParticleReader opalReader{"opal", opalTold, ParticleReader::Kind::text, tellsOpal, openOpal};
extern const ParticleReader opalRowsReader;
constinit const ParticleReader opalRowsReader{"opal", opalTold, ParticleReader::Kind::rows, tellsOpalRows,
                                              openOpal};

}  // namespace mote::prep
