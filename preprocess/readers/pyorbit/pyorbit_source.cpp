// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bunches of PyORBIT as runs: what their columns mean.
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/table/held_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "preprocess/readers/unit_names.h"
#include "protocol/base/error.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

/// A bunch of PyORBIT in text, as Bunch.dumpBunch() writes it: what its lines with % say, and
/// its rows. A value.
struct PyorbitBunch {
    std::string name;                         ///< the file's
    double momentum = 0.0;                    ///< GeV/c, of the synchronous particle; 0: not said
    double energy = 0.0;                      ///< GeV, its kinetic energy; 0: not said
    double mass = 0.0;                        ///< GeV/c^2; 0: not said
    double charge = 0.0;                      ///< elementary charges; 0: not said
    double macroSize = 0.0;                   ///< real particles of each; 0: not said
    double time = 0.0;                        ///< s, of the synchronous particle
    std::vector<std::string> attributes;      ///< names of what stands behind the six coordinates
    std::vector<std::vector<double>> values;  ///< x px y py z dE, then what else rows have, by column

    /// Errors: those of LineReader, corrupt with line and column, resourceExhausted, cancelled.
    static Result<PyorbitBunch> read(const HeldFile& file);

    /// The column in which an attribute begins; nothing where it has none, or where the number of columns
    /// does not fit the attributes that are named.
    std::optional<std::size_t> find(std::string_view attribute) const;
};

constexpr std::size_t coordinates = 6, pyorbitMaxFields = 64;

using PyorbitFields = std::array<std::string_view, pyorbitMaxFields>;

/// How many numbers PyORBIT keeps for an attribute; 0 of one that is not known here.
std::size_t sizeOf(const std::string& attribute) {
    const std::string name = lower(attribute);
    if (name == "particleinitialcoordinates" || name == "particlephaseattributes") return 6;
    const bool one = name == "macrosize" || name == "particleidnumber" || name == "lostparticleattributes" ||
                     name == "turnnumber";
    return one ? 1 : 0;
}

class PyorbitParser {
  public:
    PyorbitParser(PyorbitBunch& bunch, HeldNumbers& held) : bunch_(bunch), held_(held) {}

    Status line(std::string_view text, const std::string& where) {
        text = trim(text);
        if (text.starts_with('%')) {
            says(trim(text.substr(1)));
            return success();
        }
        if (text.empty()) return success();
        return row(text, where);
    }

  private:
    void says(std::string_view text) {
        const std::size_t count = std::min(splitFields(text, ' ', fields_), pyorbitMaxFields);
        if (count < 1) return;
        const std::string_view what = fields_[0];
        if (what == "PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES") {
            for (std::size_t i = 1; i < count; ++i) bunch_.attributes.emplace_back(fields_[i]);
        } else if (what.starts_with("BUNCH_ATTRIBUTE_") && count > 2) {
            attribute(lower(fields_[1]), parseNumber(fields_[2]).value_or(0.0));
        } else if (what == "SYNC_PART_MOMENTUM" && count > 3) {
            bunch_.momentum = std::hypot(number(1), number(2), number(3));
        } else if (what == "SYNC_PART_KIN_ENERGY" && count > 1) {
            bunch_.energy = number(1);
        } else if (what == "SYNC_PART_TIME" && count > 1) {
            bunch_.time = number(1);
        } else if (what == "info") {
            info(text);
        }
    }

    /// "info only: energy of the synchronous particle [GeV] = 1", where nothing else says it.
    void info(std::string_view text) {
        const std::size_t equals = text.rfind('=');
        if (equals == std::string_view::npos) return;
        const std::string_view rest = trim(text.substr(equals + 1));
        const double value = parseNumber(rest.substr(0, rest.find(' '))).value_or(0.0);
        if (text.find(" energy of the sync") != std::string_view::npos && bunch_.energy == 0.0)
            bunch_.energy = value;
        if (text.find(" momentum of the sync") != std::string_view::npos && bunch_.momentum == 0.0)
            bunch_.momentum = value;
    }

    void attribute(const std::string& name, double value) {
        if (name == "mass" || name == "m0c2") bunch_.mass = value;
        if (name == "charge") bunch_.charge = value;
        if (name == "macro_size") bunch_.macroSize = value;
    }

    double number(std::size_t field) const { return parseNumber(fields_[field]).value_or(0.0); }

    Status row(std::string_view text, const std::string& where) {
        const std::size_t count = splitFields(text, ' ', fields_);
        auto& values = bunch_.values;
        if (values.empty() && count >= coordinates && count <= pyorbitMaxFields) values.resize(count);
        if (count != values.size()) {
            return corrupt(where,
                           "has " + std::to_string(count) + " fields where " +
                               (values.empty() ? "6 to 64 belong"
                                               : "the first row has " + std::to_string(values.size())));
        }
        MOTE_RETURN_IF_ERROR(held_.add(count, where));
        for (std::size_t i = 0; i < count; ++i) {
            const auto value = parseNumber(fields_[i]);
            if (!value) return noNumber(fields_[i], where, std::to_string(i + 1));
            values[i].push_back(*value);
        }
        return success();
    }

    PyorbitBunch& bunch_;
    HeldNumbers& held_;
    PyorbitFields fields_;
};

Result<PyorbitBunch> PyorbitBunch::read(const HeldFile& file) {
    PyorbitBunch bunch;
    bunch.name = file.name();
    PyorbitParser parser(bunch, file.held);
    MOTE_RETURN_IF_ERROR(parseLines(file, parser));
    if (bunch.values.empty()) bunch.values.resize(coordinates);
    return bunch;
}

std::optional<std::size_t> PyorbitBunch::find(std::string_view attribute) const {
    std::size_t known = coordinates, unknown = 0;
    for (const std::string& each : attributes) {
        known += sizeOf(each);
        unknown += sizeOf(each) == 0 ? 1 : 0;
    }
    // One that is not known here has what is left; of two nobody knows.
    if (known > values.size() || unknown > 1 || (unknown == 0 && known != values.size())) return std::nullopt;
    std::size_t at = coordinates;
    for (const std::string& each : attributes) {
        if (lower(each) == lower(attribute)) return at;
        at += sizeOf(each) == 0 ? values.size() - known : sizeOf(each);
    }
    return std::nullopt;
}

constexpr double giga = 1e9;
constexpr std::size_t deviation = 5;  // the column of E - E0

Result<double> massOfBunch(const PyorbitBunch& bunch, double mass) {
    if (mass > 0.0) return mass;
    if (bunch.mass > 0.0) return bunch.mass * giga;
    return unsupported(bunch.name, "says no mass (BUNCH_ATTRIBUTE_DOUBLE mass): give it with --mass");
}

Result<double> momentumOfBunch(const PyorbitBunch& bunch, double mass) {
    if (bunch.momentum > 0.0) return bunch.momentum * giga;
    const double kinetic = bunch.energy * giga;
    if (kinetic > 0.0) return std::sqrt(kinetic * (kinetic + 2.0 * mass));
    return unsupported(
        bunch.name,
        "says nothing of the synchronous particle, in units of whose momentum its particles' are: "
        "add a line '% SYNC_PART_MOMENTUM 0 0 1.7' (GeV/c)");
}

void addAttributes(PyorbitBunch& bunch, HeldTable& table) {
    const auto ids = bunch.find("ParticleIdNumber"), weights = bunch.find("macrosize");
    const auto lost = bunch.find("LostParticleAttributes");
    const std::size_t rows = bunch.values[0].size();
    if (ids) table.add("id", std::move(bunch.values[*ids]));
    if (weights) table.add("nmacro", std::move(bunch.values[*weights]));
    if (!weights && bunch.macroSize > 0.0) table.add("nmacro", std::vector(rows, bunch.macroSize));
    if (!weights && !(bunch.macroSize > 0.0))
        table.notes.emplace_back("the bunch says no macro_size: each particle counts 1");
    if (lost) {
        table.add("lost", std::vector(rows, 1.0));
        table.notes.emplace_back("the file is one of lost particles: all of them are");
    }
    if (!bunch.attributes.empty() && !ids && !weights && !lost)
        table.notes.emplace_back("attributes of the particles are left out");
}

Result<HeldTable> tableOfPyorbit(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(auto bunch, PyorbitBunch::read(file));
    MOTE_ASSIGN_OR_RETURN(const double mass, massOfBunch(bunch, file.mass));
    MOTE_ASSIGN_OR_RETURN(const double momentum, momentumOfBunch(bunch, mass));
    HeldTable table;
    table.where = bunch.name;
    table.time = bunch.time;
    for (double& value : bunch.values[deviation]) value *= giga / momentum;
    addAttributes(bunch, table);
    static constexpr const char* names[] = {"x [m]", "px [p0]", "y [m]", "py [p0]", "zeta [m]", "ptau"};
    for (std::size_t i = 0; i <= deviation; ++i) table.add(names[i], std::move(bunch.values[i]));
    table.constants = {{TableQuantity::referenceMomentum, momentum}, {TableQuantity::mass, mass}};
    if (bunch.charge != 0.0) table.constants.push_back({TableQuantity::chargeNumber, bunch.charge});
    return table;
}

}  // namespace

extern const ParticleReader pyorbitReader;
constinit const ParticleReader pyorbitReader{
    "pyorbit", "lines '% PARTICLE_ATTRIBUTES'", ParticleReader::Kind::text,
    [](const AskedFile& file) -> Result<bool> {
        const auto says = [&](std::string_view words) { return file.begin.find(words) != file.begin.npos; };
        return file.begin.starts_with('%') &&
               (says("PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES") || says("SYNC_PART_"));
    },
    [](const AskedRun& run, Progress& progress) {
        return openHeld("pyorbit", tableOfPyorbit, run, progress);
    }};

}  // namespace mote::prep
