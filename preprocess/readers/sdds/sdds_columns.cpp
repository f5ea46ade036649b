// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/sdds/sdds_columns.h"

#include <algorithm>
#include <cmath>

#include "preprocess/constants.h"
#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

using Kind = FieldMeaning::Kind;

/// Units as our table of them writes them: without the marks "$b", "$n", "$a" of sub- and superscripts, and
/// elegant's "m$be$nc" as m c.
std::string plainUnit(std::string_view units) {
    std::string plain;
    for (std::size_t i = 0; i < units.size(); ++i) {
        if (units[i] == '$' && i + 1 < units.size())
            ++i;
        else
            plain += units[i];
    }
    const std::string_view trimmed = trim(plain);
    return trimmed == "mec" || trimmed == "m_e c" || trimmed == "m_ec" ? "m c" : std::string(trimmed);
}

bool unitIsMassTimesC(const SddsField& field) {
    const std::string unit = plainUnit(field.units);
    return unit == "m c" || unit == "mc" || unit == "m*c";
}

std::string named(std::string_view name, const SddsField& field) {
    const std::string unit = plainUnit(field.units);
    return std::string(name) + (unit.empty() ? "" : " [" + unit + "]");
}

Result<double> slopeFactor(const SddsField& field, const std::string& where) {
    const std::string unit = plainUnit(field.units);
    if (unit.empty() || unit == "rad" || unit == "1") return 1.0;
    if (unit == "mrad") return 1e-3;
    return unsupported(where, "has the unit '" + unit + "', which is not known");
}

}  // namespace

struct SddsColumns::Rows {
    const std::vector<std::size_t>& columns;
    const SddsRows& rows;

    Values operator()(const Item& item) const {
        const auto at = std::find(columns.begin(), columns.end(), item.column) - columns.begin();
        return {rows.columns[static_cast<std::size_t>(at)].data(), item.factor};
    }
};

Result<SddsColumns> SddsColumns::of(const SddsHeader& header, double mass, const std::string& file) {
    SddsColumns columns;
    columns.mass_ = mass;
    bool needsMass = false;
    for (const SddsField& field : header.columns) {
        needsMass = needsMass || unitIsMassTimesC(field) || field.name == "p" || field.name == "pr";
    }
    if (mass <= 0.0 && needsMass) {
        columns.mass_ = electronMass;
        columns.massAssumed_ = true;
    }
    for (std::size_t i = 0; i < header.columns.size(); ++i) {
        MOTE_RETURN_IF_ERROR(columns.add(header, i, file));
    }
    for (const SddsField& field : header.parameters) {
        if (field.name != "Charge") continue;
        const std::string where = file + ", parameter 'Charge'";
        MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(named("charge", field), 0.0, where));
        columns.chargeFactor_ = meaning->factor;
    }
    for (std::size_t i = 0; i + 1 < columnCount; ++i) {
        if (columns.has(static_cast<Column>(i)) && static_cast<Column>(i) != Column::weight) return columns;
    }
    return corrupt(file,
                   "has no column of a particle: none of x, xp, y, yp, t, p (elegant) or z, px, py, pz");
}

Status SddsColumns::add(const SddsHeader& header, std::size_t column, const std::string& file) {
    const SddsField& field = header.columns[column];
    const std::string where = file + ", column '" + field.name + "'";
    if (auto record = field.number() ? recordOf(named(field.name, field)) : std::nullopt) {
        records_.push_back(*std::move(record));
        recordColumns_.push_back(column);
    }
    const bool elegant = field.name == "xp" || field.name == "yp" || field.name == "p" || field.name == "dt";
    const bool ring = field.name == "r" || field.name == "pr" || field.name == "pphi";
    std::optional<FieldMeaning> meaning;
    if (!elegant && !ring) {
        MOTE_ASSIGN_OR_RETURN(
            meaning, fieldMeaning(field.number() ? named(field.name, field) : field.name, mass_, where));
        if (!meaning) return success();
    }
    if (!field.number()) return unsupported(where, "is a text; a number is needed");
    if (elegant) return addElegant(field, column, where);
    if (ring) return addRing(field, column, where);
    if (meaning->kind != Kind::column) {
        lost_.push_back({column, meaning->kind});
        return success();
    }
    if (meaning->column == Column::id ? id_.has_value() : item(meaning->column).has_value()) {
        return corrupt(where, "means the same as another column");
    }
    if (meaning->column == Column::id)
        id_ = column;
    else
        items_[static_cast<std::size_t>(meaning->column)] = Item{column, meaning->factor};
    return success();
}

Status SddsColumns::addElegant(const SddsField& field, std::size_t column, const std::string& where) {
    if (field.name == "p") {
        // Without a unit it is elegant's own, m c.
        MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(named("pz", field), mass_, where));
        p_ = Item{column, plainUnit(field.units).empty() ? mass_ : meaning->factor};
    } else if (field.name == "dt") {
        MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(named("t", field), mass_, where));
        dt_ = Item{column, meaning->factor};
    } else {
        MOTE_ASSIGN_OR_RETURN(const auto factor, slopeFactor(field, where));
        (field.name == "xp" ? xp_ : yp_) = Item{column, factor};
    }
    return success();
}

/// spiffe's columns; without a unit its momenta are in m c.
Status SddsColumns::addRing(const SddsField& field, std::size_t column, const std::string& where) {
    const bool place = field.name == "r";
    const bool plain = !place && plainUnit(field.units).empty();
    MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(named(place ? "x" : "px", field), mass_, where));
    (place ? r_ : field.name == "pr" ? pr_ : pphi_) = Item{column, plain ? mass_ : meaning->factor};
    return success();
}

bool SddsColumns::momenta() const {
    return slopes() || (rings() && item(Column::pz)) ||
           (item(Column::px) && item(Column::py) && item(Column::pz));
}

bool SddsColumns::zFromTime() const {
    return !item(Column::z) && timeColumn() && momenta() && mass_ > 0.0;
}

bool SddsColumns::has(Column column) const {
    if (column == Column::id) return id_.has_value();
    if (item(column)) return true;
    if (isMomentum(column)) return slopes() || (rings() && column != Column::pz);
    if (column == Column::x || column == Column::y) return rings();
    if (column == Column::t) return dt_.has_value();
    return column == Column::z && zFromTime();
}

std::size_t SddsColumns::recordColumn(const std::string& name) const {
    const auto found = std::ranges::find(records_, name, &SourceRecord::name);
    return recordColumns_[static_cast<std::size_t>(found - records_.begin())];
}

std::optional<std::size_t> SddsColumns::timeColumn() const {
    const auto& time = item(Column::t) ? item(Column::t) : dt_;
    return time ? std::optional(time->column) : std::nullopt;
}

double SddsColumns::timeFactor() const {
    return item(Column::t) ? item(Column::t)->factor : dt_ ? dt_->factor : 1.0;
}

std::vector<std::size_t> SddsColumns::needed(const std::vector<Column>& wanted) const {
    std::vector<std::size_t> columns;
    const auto add = [&](const std::optional<Item>& some) {
        if (some) columns.push_back(some->column);
    };
    const auto addMomentum = [&](Column column) {
        if (item(column)) return add(item(column));
        if (rings()) {
            for (const auto& some : {pr_, pphi_}) add(some);
        } else {
            for (const auto& some : {xp_, yp_, p_}) add(some);
        }
    };
    for (const Column column : wanted) {
        if (column == Column::id || isRecord(column)) continue;
        if (isMomentum(column)) {
            addMomentum(column);
        } else if ((column == Column::x || column == Column::y) && rings()) {
            add(r_);
        } else if (column == Column::z && zFromTime()) {
            for (const Column momentum : {Column::px, Column::py, Column::pz}) addMomentum(momentum);
            columns.push_back(*timeColumn());
        } else if (column == Column::t) {
            columns.push_back(*timeColumn());
        } else {
            add(item(column));
        }
    }
    for (const Lost& lost : lost_) columns.push_back(lost.column);
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    return columns;
}

/// A ring becomes one particle on it, turned by the golden angle from the ring before it: so the particles
/// lie about the axis as evenly as the rings do, and every file gives the same ones.
void SddsColumns::fillRing(Column column, const Rows& rows, std::uint64_t begin,
                           std::vector<double>& values) const {
    const bool place = column == Column::x || column == Column::y;
    const bool first = column == Column::x || column == Column::px;
    const Values radial = rows(place ? *r_ : *pr_);
    const bool turns = !place && pphi_;
    const Values azimuthal = rows(turns ? *pphi_ : place ? *r_ : *pr_);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double angle = std::fmod(static_cast<double>(begin + i) * goldenAngle, radiansPerTurn);
        const double across = turns ? azimuthal[i] : 0.0;
        values[i] = first ? radial[i] * std::cos(angle) - across * std::sin(angle)
                          : radial[i] * std::sin(angle) + across * std::cos(angle);
    }
}

/// elegant's xp and yp are slopes, p is the whole momentum.
void SddsColumns::fillMomentum(Column column, const Rows& rows, std::uint64_t begin,
                               std::vector<double>& values) const {
    if (const auto& direct = item(column)) {
        const Values from = rows(*direct);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = from[i];
        return;
    }
    if (rings()) return fillRing(column, rows, begin, values);
    const Values xp = rows(*xp_), yp = rows(*yp_), p = rows(*p_);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double slope = column == Column::px ? xp[i] : column == Column::py ? yp[i] : 1.0;
        values[i] = p[i] * slope / std::sqrt(1.0 + xp[i] * xp[i] + yp[i] * yp[i]);
    }
}

/// Particles of a step pass one plane at times of their own; where each was at the mean of those times.
void SddsColumns::fillPlaces(const Rows& rows, double meanTime, std::uint64_t begin,
                             std::vector<double>& values) const {
    std::vector<double> px(values.size()), py(values.size());
    fillMomentum(Column::px, rows, begin, px);
    fillMomentum(Column::py, rows, begin, py);
    fillMomentum(Column::pz, rows, begin, values);
    const Values time = rows({*timeColumn(), timeFactor()});
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double energy =
            std::sqrt(mass_ * mass_ + px[i] * px[i] + py[i] * py[i] + values[i] * values[i]);
        values[i] = -speedOfLight * values[i] / energy * (time[i] - meanTime);
    }
}

void SddsColumns::fill(const std::vector<Column>& wanted, const SddsRows& rows, double meanTime,
                       ParticleChunk& chunk) const {
    const std::vector<std::size_t> columns = needed(wanted);
    const Rows lookup{columns, rows};
    for (const Column column : wanted) {
        if (column == Column::id || isRecord(column)) continue;
        std::vector<double>& values = chunk[column];
        values.assign(chunk.size, 1.0);
        if (isMomentum(column)) {
            fillMomentum(column, lookup, chunk.begin, values);
        } else if ((column == Column::x || column == Column::y) && !item(column)) {
            if (rings()) fillRing(column, lookup, chunk.begin, values);
        } else if (column == Column::z && zFromTime()) {
            fillPlaces(lookup, meanTime, chunk.begin, values);
        } else if (column == Column::t || item(column)) {
            const Values from =
                column == Column::t ? lookup({*timeColumn(), timeFactor()}) : lookup(*item(column));
            for (std::size_t i = 0; i < chunk.size; ++i) values[i] = from[i];
        }
    }
    chunk.lost.assign(chunk.size, 0);
    for (const Lost& lost : lost_) {
        const Values from = lookup({lost.column, 1.0});
        for (std::size_t i = 0; i < chunk.size; ++i) chunk.lost[i] |= saysLost(lost.kind, from[i]) ? 1 : 0;
    }
}

}  // namespace mote::prep
