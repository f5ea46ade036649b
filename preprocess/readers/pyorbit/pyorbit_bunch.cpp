// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/pyorbit/pyorbit_bunch.h"

#include <array>
#include <cmath>

#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "preprocess/readers/unit_names.h"
#include "protocol/scene/utf8.h"

namespace mote::prep {
namespace {

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

}  // namespace

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

}  // namespace mote::prep
