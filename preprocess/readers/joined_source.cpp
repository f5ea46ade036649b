// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/joined_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "protocol/quantity/quantity.h"

namespace mote::prep {
namespace {

constexpr std::string_view speciesRecord = "species", massRecord = "mass", chargeRecord = "particle_charge";
constexpr int idBits = 56;  // below the place of a species among an id's bits

/// What a record of the joined run is: a number of each species, or one of each part's own.
struct JoinedRecord {
    SourceRecord said;
    std::vector<double> values;       ///< by part; empty: read
    std::vector<std::size_t> places;  ///< by part, among its records
};

class JoinedSource final : public ParticleSource {
  public:
    JoinedSource(std::vector<SpeciesPart> parts, Progress& progress)
        : parts_(std::move(parts)), progress_(progress) {}

    /// Errors: as joinSpecies.
    Status join();

    std::string format() const override { return parts_.front().source->format(); }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override { return has_[static_cast<std::size_t>(column)]; }
    std::vector<SourceRecord> records() const override {
        std::vector<SourceRecord> all;
        for (const JoinedRecord& record : records_) all.push_back(record.said);
        return all;
    }
    double mass() const override { return mass_; }
    std::string species() const override { return species_; }
    double particleCharge() const override { return charge_; }
    std::string weightUnit() const override { return weightUnit_; }
    std::uint64_t keptBytes(std::size_t step, std::size_t threads) const override {
        std::uint64_t sum = 0;
        for (std::size_t part = 0; part < parts_.size(); ++part) {
            if (const Place place = places_[step][part])
                sum += parts_[part].source->keptBytes(*place, threads);
        }
        return sum;
    }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    using Place = std::optional<std::size_t>;  ///< a part's step

    void joinSteps();
    void joinColumns();
    void joinMasses();
    Status joinWeights();
    void joinRecords();
    void noteNames();
    Status readPart(std::size_t part, std::size_t step, std::uint64_t begin, std::size_t count,
                    const std::vector<Column>& wanted);
    void take(std::size_t part, std::size_t at, const std::vector<Column>& wanted, ParticleChunk& chunk);

    template <class Value>
    bool allSame(Value value) const {
        const auto first = value(*parts_.front().source);
        return std::ranges::all_of(parts_, [&](const auto& part) { return value(*part.source) == first; });
    }
    const JoinedRecord& recordOf(Column column) const {
        return records_[static_cast<std::size_t>(column) - columnCount];
    }

    std::vector<SpeciesPart> parts_;
    Progress& progress_;
    std::vector<SourceStep> steps_;
    std::vector<std::vector<Place>> places_;  ///< by step, then part
    bool has_[columnCount] = {};
    std::vector<JoinedRecord> records_;
    double mass_ = 0.0, charge_ = 0.0;
    std::string species_, weightUnit_;
    ParticleChunk chunk_;  ///< of a part
};

bool isPhotons(const ParticleSource& source) {
    return source.species() == "photon";
}

bool alike(double a, double b) {
    constexpr double rounding = 1e-9;  // of masses in a file, from kg to eV/c^2
    return std::abs(a - b) <= rounding * std::max(std::abs(a), std::abs(b));
}

Status JoinedSource::join() {
    joinSteps();
    joinColumns();
    joinMasses();
    MOTE_RETURN_IF_ERROR(joinWeights());
    joinRecords();
    noteNames();
    return success();
}

/// The iterations of all parts, each once; one that a part has in several files stays so often.
void JoinedSource::joinSteps() {
    std::map<std::pair<std::int64_t, std::size_t>, std::vector<Place>> places;
    for (std::size_t part = 0; part < parts_.size(); ++part) {
        const auto& own = parts_[part].source->steps();
        std::size_t again = 0;
        for (std::size_t step = 0; step < own.size(); ++step) {
            again = step > 0 && own[step].iteration == own[step - 1].iteration ? again + 1 : 0;
            auto& place = places[{own[step].iteration, again}];
            place.resize(parts_.size());
            place[part] = step;
        }
    }
    for (auto& [iteration, place] : places) {
        SourceStep joined;
        bool told = false;
        for (std::size_t part = 0; part < parts_.size(); ++part) {
            if (!place[part]) continue;
            const SourceStep& own = parts_[part].source->steps()[*place[part]];
            if (joined.file.empty() || (!told && own.particles > 0)) {
                joined.file = own.file;
                joined.time = own.time;
                told = own.particles > 0;
            }
            joined.particles += own.particles;
        }
        joined.iteration = iteration.first;
        steps_.push_back(std::move(joined));
        places_.push_back(std::move(place));
    }
}

/// Coordinates are there where all have them; who has no weights counts one each.
void JoinedSource::joinColumns() {
    for (std::size_t i = 0; i < columnCount; ++i) {
        const auto column = static_cast<Column>(i);
        std::string with, without;
        for (const SpeciesPart& part : parts_) {
            auto& names = part.source->has(column) ? with : without;
            names += (names.empty() ? "" : ", ") + part.name;
        }
        has_[i] = without.empty() || (column == Column::weight && !with.empty());
        if (with.empty() || without.empty()) continue;
        if (column == Column::weight)
            progress_.note(fmt::format("no weights: each of {} counts as one", without));
        else if (column == Column::id)
            progress_.note(fmt::format("ids are left out: {} have none", without));
        else
            progress_.note(
                fmt::format("{} is left out: {} do not have it", knownQuantities()[i].name, without));
    }
}

/// One mass and one charge where they are the same; else each species' own in a column.
void JoinedSource::joinMasses() {
    std::vector<double> masses, charges;
    bool known = true;
    for (const SpeciesPart& part : parts_) {
        masses.push_back(part.source->mass());
        charges.push_back(part.source->particleCharge());
        known = known && (masses.back() > 0.0 || isPhotons(*part.source));
    }
    std::vector<double> numbers;
    for (std::size_t part = 0; part < parts_.size(); ++part) numbers.push_back(static_cast<double>(part));
    records_.push_back({{std::string(speciesRecord), "1", true}, std::move(numbers), {}});
    if (allSame([](const ParticleSource& source) { return source.species(); }))
        species_ = parts_.front().source->species();
    const auto same = [](const std::vector<double>& all) {
        return std::ranges::all_of(all, [&](double one) { return alike(one, all.front()); });
    };
    if (same(masses))
        mass_ = masses.front();
    else if (known)
        records_.push_back({{std::string(massRecord), "eV/c^2", true}, std::move(masses), {}});
    else
        progress_.note("the mass of some of the species is not known: there are no energies");
    if (same(charges))
        charge_ = charges.front();
    else
        records_.push_back({{std::string(chargeRecord), "C", true}, std::move(charges), {}});
}

/// Weights of which one number of a charge cannot be made have no unit, so that nobody makes one.
Status JoinedSource::joinWeights() {
    const SpeciesPart* first = nullptr;
    bool all = true;
    for (const SpeciesPart& part : parts_) {
        const std::string unit = part.source->weightUnit();
        all = all && !unit.empty();
        if (unit.empty()) continue;
        if (first == nullptr) first = &part;
        if (unit == first->source->weightUnit()) continue;
        return invalid("species",
                       fmt::format("weights of {} and of {} do not go together: \"{}\" and \"{}\" ",
                                   first->name, part.name, first->source->weightUnit(), unit) +
                           "(1: real particles, C: their charge)");
    }
    if (first == nullptr || !all) return success();
    const bool ofCharge = first->source->weightUnit() == "C";
    if (ofCharge || charge_ != 0.0 || !species_.empty()) weightUnit_ = first->source->weightUnit();
    if (ofCharge && charge_ == 0.0)
        progress_.note(
            "weights are the magnitudes of charges; those of the species differ, and signs are lost");
    if (weightUnit_.empty())
        progress_.note(
            "weights count real particles, whose charges differ: no charge of all is told; the sum "
            "of weight*particle_charge is");
    return success();
}

/// Beside what tells the species apart: what all have under one name, in one unit.
void JoinedSource::joinRecords() {
    std::vector<std::vector<SourceRecord>> own;
    for (const SpeciesPart& part : parts_) own.push_back(part.source->records());
    std::string left;
    for (const SourceRecord& record : own.front()) {
        JoinedRecord joined{record, {}, {}};
        for (const auto& records : own) {
            const auto same = std::ranges::find_if(records, [&](const SourceRecord& one) {
                return one.name == record.name && one.unit == record.unit;
            });
            if (same != records.end())
                joined.places.push_back(static_cast<std::size_t>(same - records.begin()));
        }
        const bool taken = std::ranges::any_of(
            records_, [&](const JoinedRecord& one) { return one.said.name == record.name; });
        if (joined.places.size() == parts_.size() && !taken && records_.size() < mostRecords)
            records_.push_back(std::move(joined));
        else
            left += (left.empty() ? "" : ", ") + record.name;
    }
    if (!left.empty()) progress_.note("columns that not all species have alike are left out: " + left);
}

void JoinedSource::noteNames() {
    std::string names;
    for (std::size_t part = 0; part < parts_.size(); ++part)
        names += fmt::format("{}{} {}", part == 0 ? "" : ", ", part, parts_[part].name);
    progress_.note(
        fmt::format("the column {} says which species a particle is of: {}", speciesRecord, names));
    if (has(Column::id) && parts_.size() > 1)
        progress_.note(fmt::format("ids of the species N have N in their highest byte, so that all differ"));
}

/// Reads into chunk_.
Status JoinedSource::readPart(std::size_t part, std::size_t step, std::uint64_t begin, std::size_t count,
                              const std::vector<Column>& wanted) {
    std::vector<Column> own;
    for (const Column column : wanted) {
        if (!isRecord(column)) {
            own.push_back(column);
        } else if (recordOf(column).values.empty()) {
            own.push_back(recordColumn(recordOf(column).places[part]));
        }
    }
    return parts_[part].source->read(step, begin, count, own, chunk_);
}

/// Takes the rows of chunk_ from `at` on.
void JoinedSource::take(std::size_t part, std::size_t at, const std::vector<Column>& wanted,
                        ParticleChunk& chunk) {
    const auto to = static_cast<std::ptrdiff_t>(at);
    const std::size_t count = chunk_.size;
    if (!chunk_.lost.empty()) std::ranges::copy(chunk_.lost, chunk.lost.begin() + to);
    for (const Column column : wanted) {
        if (column == Column::id) {
            if (!has(Column::id)) continue;
            const std::uint64_t bits = std::uint64_t{part} << idBits;
            std::ranges::transform(chunk_.id, chunk.id.begin() + to,
                                   [bits](std::uint64_t id) { return id ^ bits; });
            continue;
        }
        auto& values = chunk[column];
        if (isRecord(column) && !recordOf(column).values.empty()) {
            std::fill_n(values.begin() + to, count, recordOf(column).values[part]);
            continue;
        }
        const Column own = isRecord(column) ? recordColumn(recordOf(column).places[part]) : column;
        std::ranges::copy(chunk_[own], values.begin() + to);
    }
}

Status JoinedSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                          const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (step >= steps_.size()) return invalid("", "there is no such step");
    const std::uint64_t rows = steps_[step].particles;
    if (begin > rows || count > rows - begin)
        return invalid(steps_[step].file, "rows that the step does not have were asked for");
    chunk.begin = begin;
    chunk.size = count;
    chunk.lost.assign(count, 0);
    for (const Column column : wanted) {
        if (column == Column::id) {
            chunk.id.resize(count);
            if (!has(Column::id)) std::iota(chunk.id.begin(), chunk.id.end(), begin);
        } else {
            chunk[column].resize(count);
        }
    }
    std::uint64_t first = 0;  // of the part's rows, among all
    for (std::size_t part = 0; part < parts_.size(); ++part) {
        const Place place = places_[step][part];
        if (!place) continue;
        const std::uint64_t own = parts_[part].source->steps()[*place].particles;
        const std::uint64_t from = std::max(begin, first), end = std::min(begin + count, first + own);
        if (from < end) {
            MOTE_RETURN_IF_ERROR(
                readPart(part, *place, from - first, static_cast<std::size_t>(end - from), wanted));
            take(part, static_cast<std::size_t>(from - begin), wanted, chunk);
        }
        first += own;
    }
    return success();
}

}  // namespace

Result<std::vector<std::string>> namesOfSpecies(const std::string& text) {
    if (text.find(',') == std::string::npos) return std::vector<std::string>{text};
    auto names = splitNames(text);
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i].empty()) return invalid("species", "has a comma without a name");
        if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
            names.begin() + static_cast<std::ptrdiff_t>(i))
            return invalid("species", fmt::format("names {} twice", names[i]));
    }
    if (names.size() > mostSpecies)
        return invalid("species",
                       fmt::format("names {} species; a plot has at most {}", names.size(), mostSpecies));
    return names;
}

Result<std::unique_ptr<ParticleSource>> joinSpecies(std::vector<SpeciesPart> parts, Progress& progress) {
    auto joined = std::make_unique<JoinedSource>(std::move(parts), progress);
    MOTE_RETURN_IF_ERROR(joined->join());
    return std::unique_ptr<ParticleSource>(std::move(joined));
}

}  // namespace mote::prep
