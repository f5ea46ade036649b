// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tracks of MAD-X and PTC as runs: what their columns mean, and which rows are a step.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/table/held_source.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

/// A table in TFS, as MAD-X and PTC write it: "@" lines with what is said of all rows, "*" names, "$"
/// types, "#segment" lines between the steps. A value.
struct TfsFile {
    std::string name;                         ///< of the file
    std::map<std::string, std::string> says;  ///< of "@" lines, by names in capitals
    std::vector<std::string> names;           ///< of the columns kept, in capitals
    std::vector<std::vector<double>> values;  ///< by name
    std::vector<std::size_t> segments;        ///< the rows before which one begins

    const std::vector<double>* find(std::string_view name) const;
    std::optional<double> number(const std::string& name) const;  ///< of an "@" line

    /// Keeps the columns of tracks. Errors: corrupt (a row without a number, no names), those of LineReader,
    /// cancelled.
    static Result<TfsFile> read(const HeldFile& held);
};

constexpr std::string_view tracks[] = {"NUMBER", "TURN", "X", "PX", "Y", "PY", "T", "PT", "S", "E"};
constexpr std::size_t tfsMaxFields = 1024;
constexpr std::size_t maxSays = 4096;

using TfsFields = std::array<std::string_view, tfsMaxFields>;

std::string upper(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return result;
}

class TfsParser {
  public:
    TfsParser(TfsFile& file, HeldNumbers& held) : file_(file), held_(held) {}

    Status line(std::string_view text, const std::string& where) {
        text = trim(text);
        if (text.empty()) return success();
        switch (text.front()) {
            case '@':
                return say(text.substr(1));
            case '*':
                return takeNames(text.substr(1), where);
            case '$':
                return success();
            case '#':
                if (text.starts_with("#segment") && !file_.values.empty())
                    file_.segments.push_back(file_.values.front().size());
                return success();
            default:
                return row(text, where);
        }
    }

  private:
    /// "NAME %05s value": the value is the rest, without quotes.
    Status say(std::string_view text) {
        text = trim(text);
        const std::size_t name = std::min(text.find_first_of(" \t"), text.size());
        std::string_view rest = trim(text.substr(name));
        if (rest.starts_with('%')) rest = trim(rest.substr(std::min(rest.find_first_of(" \t"), rest.size())));
        if (rest.size() >= 2 && rest.front() == '"' && rest.back() == '"')
            rest = rest.substr(1, rest.size() - 2);
        if (file_.says.size() < maxSays) file_.says[upper(text.substr(0, name))] = std::string(rest);
        return success();
    }

    Status takeNames(std::string_view text, const std::string& where) {
        const std::size_t count = splitFields(text, ' ', fields_);
        if (count > tfsMaxFields) return unsupported(where, "names more than 1024 columns");
        if (!file_.names.empty()) return corrupt(where, "names the columns a second time");
        columns_ = count;
        for (std::size_t i = 0; i < count; ++i) {
            std::string name = upper(fields_[i]);
            const bool kept = std::find(std::begin(tracks), std::end(tracks), name) != std::end(tracks);
            const bool twice = std::find(file_.names.begin(), file_.names.end(), name) != file_.names.end();
            if (!kept || twice) continue;
            used_.push_back(i);
            file_.names.push_back(std::move(name));
        }
        file_.values.resize(used_.size());
        return success();
    }

    Status row(std::string_view text, const std::string& where) {
        if (file_.names.empty()) return corrupt(where, "is a row before the line of names");
        const std::size_t count = splitFields(text, ' ', fields_);
        if (count < columns_) {
            return corrupt(where, "has " + std::to_string(count) + " fields where " +
                                      std::to_string(columns_) + " are named");
        }
        MOTE_RETURN_IF_ERROR(held_.add(used_.size(), where));
        for (std::size_t i = 0; i < used_.size(); ++i) {
            const auto value = parseNumber(fields_[used_[i]]);
            if (!value) return noNumber(fields_[used_[i]], where, file_.names[i]);
            file_.values[i].push_back(*value);
        }
        return success();
    }

    TfsFile& file_;
    HeldNumbers& held_;
    TfsFields fields_;
    std::size_t columns_ = 0;
    std::vector<std::size_t> used_;
};

const std::vector<double>* TfsFile::find(std::string_view wanted) const {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == wanted) return &values[i];
    }
    return nullptr;
}

std::optional<double> TfsFile::number(const std::string& wanted) const {
    const auto found = says.find(wanted);
    return found == says.end() ? std::nullopt : parseNumber(found->second);
}

Result<TfsFile> TfsFile::read(const HeldFile& held) {
    TfsFile file;
    file.name = held.name();
    TfsParser parser(file, held.held);
    MOTE_RETURN_IF_ERROR(parseLines(held, parser));
    return file;
}

constexpr double giga = 1e9;
// How well energies that a file writes with some ten digits can agree.
constexpr double energyTolerance = 1e-7;
// Of the energy: what is less is lost between an energy and a momentum of so many digits.
constexpr double leastMassShare = 0.1;

/// The reference particle of a track.
struct Reference {
    double momentum = 0.0;  ///< eV/c
    double mass = 0.0;      ///< eV/c^2; 0: not known
    std::string note;
};

/// E = E0 + PT p0 over the rows, where the file writes each particle's energy; nothing where it writes that
/// of the reference particle.
std::optional<std::pair<double, double>> energyLine(const std::vector<double>& energy,
                                                    const std::vector<double>& deviation) {
    const auto [low, high] = std::minmax_element(deviation.begin(), deviation.end());
    if (deviation.size() < 2 || !(*high > *low)) return std::nullopt;
    const std::size_t a = static_cast<std::size_t>(low - deviation.begin());
    const std::size_t b = static_cast<std::size_t>(high - deviation.begin());
    const double momentum = (energy[b] - energy[a]) / (*high - *low);
    const double reference = energy[a] - momentum * *low;
    if (!(momentum > 0.0) || !(reference >= momentum * (1.0 - energyTolerance))) return std::nullopt;
    for (std::size_t i = 0; i < energy.size(); ++i) {
        if (!(std::abs(reference + momentum * deviation[i] - energy[i]) <= energyTolerance * reference))
            return std::nullopt;
    }
    return std::pair(reference, momentum);
}

/// The mass between an energy and a momentum, as that of a known particle within 1%; nothing where their
/// digits do not tell it.
std::optional<double> massBetween(double energy, double momentum) {
    const double mass = std::sqrt(std::max((energy - momentum) * (energy + momentum), 0.0));
    if (!(mass > leastMassShare * energy)) return std::nullopt;
    for (const char* name : {"electron", "muon", "pion+", "proton", "deuteron"}) {
        if (std::abs(mass / *speciesMass(name) - 1.0) < 0.01) return *speciesMass(name);
    }
    return mass;
}

double massOfTfs(const TfsFile& file, double mass) {
    if (mass > 0.0) return mass;
    if (const auto own = file.number("MASS"); own && *own > 0.0) return *own * giga;
    const auto particle = file.says.find("PARTICLE");
    return particle == file.says.end() ? 0.0 : speciesMass(particle->second).value_or(0.0);
}

Error noReference(const TfsFile& file, const char* what) {
    return {ErrorCode::unsupported, file.name,
            "has momenta in units of the reference momentum and says neither PC nor " + std::string(what) +
                ": add a line '@ PC %le 450' (GeV/c) above its names"};
}

Result<Reference> referenceOf(const TfsFile& file, double mass) {
    Reference reference;
    reference.mass = massOfTfs(file, mass);
    const auto momentum = file.number("PC");
    const auto* energy = file.find("E");
    const auto* deviation = file.find("PT");
    const auto line = energy && deviation ? energyLine(*energy, *deviation) : std::nullopt;
    if (line && reference.mass == 0.0) {
        const double p0 = momentum ? *momentum : line->second;
        const auto found = massBetween(line->first * giga, p0 * giga);
        reference.mass = found.value_or(electronMass);
        reference.note = found ? "the mass is that which the energies in column E are of"
                               : "the file names no mass: the particles are taken for electrons";
    }
    if (momentum && *momentum > 0.0) {
        reference.momentum = *momentum * giga;
        return reference;
    }
    auto total = file.number("ENERGY");
    if (!total && file.number("GAMMA") && reference.mass > 0.0)
        total = *file.number("GAMMA") * reference.mass / giga;
    if (!total && line) {
        total = line->first;
        if (!reference.note.empty()) reference.note += "; ";
        reference.note += "the reference momentum is that of the energies in column E";
    }
    const bool same =
        energy && !energy->empty() &&
        std::all_of(energy->begin(), energy->end(), [&](double value) { return value == energy->front(); });
    if (!total && same) total = energy->front();
    if (!total || !(*total > 0.0)) return noReference(file, "ENERGY");
    if (reference.mass <= 0.0) return noReference(file, "MASS (or give --mass)");
    reference.momentum = std::sqrt((*total * giga - reference.mass) * (*total * giga + reference.mass));
    if (!(reference.momentum > 0.0)) return noReference(file, "an ENERGY above the mass");
    return reference;
}

/// Which column of ours a column of a track is; its own name for those that are none: a record of the source.
std::string canonicalOfTfs(const std::string& name) {
    static const std::map<std::string, std::string> names = {
        {"NUMBER", "id"},  {"X", "x [m]"},    {"PX", "px [p0]"}, {"Y", "y [m]"},
        {"PY", "py [p0]"}, {"T", "late [m]"}, {"PT", "ptau"}};
    const auto found = names.find(name);
    return found == names.end() ? name : found->second;
}

/// Puts a file's rows into tables: a segment each, else a turn each.
class TfsSorter {
  public:
    /// Files of one particle each (track.obs0001.p0001) share their steps.
    explicit TfsSorter(bool shared) : shared_(shared) {}

    void add(const TfsFile& file, const Reference& reference) {
        const auto* turns = file.find("TURN");
        const std::size_t rows = file.values.empty() ? 0 : file.values.front().size();
        std::size_t segment = 0;
        if (!shared_) keys_.clear();
        for (std::size_t row = 0; row < rows; ++row) {
            while (segment < file.segments.size() && file.segments[segment] <= row) ++segment;
            const double turn = turns ? (*turns)[row] : 0.0;
            HeldTable& table = tableOf(file, reference, file.segments.empty() ? turn : double(segment), turn);
            std::size_t at = 0;
            for (std::size_t i = 0; i < file.names.size(); ++i) {
                // MAD's T is -c times the delay.
                table.values[at++].push_back(file.names[i] == "T" ? -file.values[i][row]
                                                                  : file.values[i][row]);
            }
        }
    }

    std::vector<HeldTable> tables;

  private:
    HeldTable& tableOf(const TfsFile& file, const Reference& reference, double key, double turn) {
        const auto found = keys_.find(key);
        if (found != keys_.end()) return tables[found->second];
        keys_[key] = tables.size();
        HeldTable table;
        table.where = file.name;
        if (shared_ || file.segments.empty()) table.iteration = static_cast<std::int64_t>(turn);
        for (const std::string& name : file.names) {
            table.names.push_back(canonicalOfTfs(name));
        }
        table.values.resize(table.names.size());
        table.constants = {{TableQuantity::referenceMomentum, reference.momentum}};
        if (reference.mass > 0.0) table.constants.push_back({TableQuantity::mass, reference.mass});
        if (const auto charge = file.number("CHARGE"))
            table.constants.push_back({TableQuantity::chargeNumber, *charge});
        if (!reference.note.empty()) table.notes.push_back(reference.note);
        tables.push_back(std::move(table));
        return tables.back();
    }

    bool shared_;
    std::map<double, std::size_t> keys_;
};

Status checkTrack(const TfsFile& file) {
    const auto type = file.says.find("TYPE");
    const std::string kind = type == file.says.end() ? "" : type->second;
    for (const char* name : {"X", "PX", "Y", "PY"}) {
        if (file.find(name) != nullptr) continue;
        return unsupported(file.name, "is a TFS table" + (kind.empty() ? "" : " of type " + kind) +
                                          " without the column " + name + ", so no track of particles");
    }
    if (file.find("NUMBER") != nullptr || kind.find("TRACK") != std::string::npos) return success();
    return unsupported(
        file.name, "is a TFS table of type '" + kind +
                       "' without the column NUMBER: optics, no track of particles (track.obs*, trackone)");
}

/// One particle, its turns below each other, and so all files.
bool ofOneParticle(const TfsFile& file) {
    const auto* numbers = file.find("NUMBER");
    return numbers != nullptr && numbers->size() > 0 && file.segments.empty() &&
           std::all_of(numbers->begin(), numbers->end(),
                       [&](double number) { return number == numbers->front(); });
}

/// All files are read before the first step is made: of one particle each, they share their steps.
class TfsSource : public HeldSource {
  public:
    TfsSource(double mass, Progress& progress) : HeldSource("tfs", mass, progress), mass_(mass) {}

  protected:
    Status addFile(const std::filesystem::path& path) override {
        MOTE_ASSIGN_OR_RETURN(auto file, TfsFile::read(fileAt(path)));
        MOTE_RETURN_IF_ERROR(checkTrack(file));
        files_.push_back(std::move(file));
        return success();
    }
    bool anyRead() const override { return !files_.empty(); }
    Status finish() override {
        TfsSorter sorter(files_.size() > 1 && std::all_of(files_.begin(), files_.end(), ofOneParticle));
        for (const TfsFile& file : files_) {
            MOTE_ASSIGN_OR_RETURN(const auto reference, referenceOf(file, mass_));
            sorter.add(file, reference);
        }
        files_.clear();
        tables_ = std::move(sorter.tables);
        return HeldSource::finish();
    }

  private:
    double mass_;
    std::vector<TfsFile> files_;
};

}  // namespace

extern const ParticleReader tfsReader;
constinit const ParticleReader tfsReader{
    "tfs", "lines '@ NAME' of TFS", ParticleReader::Kind::text,
    [](const AskedFile& file) -> Result<bool> { return file.words().starts_with("@ "); },
    [](const AskedRun& run, Progress& progress) {
        return openSeries(std::make_unique<TfsSource>(run.mass, progress), inOrder(run.files));
    }};

}  // namespace mote::prep
