// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tracks of MAD-X and PTC as runs: what their columns mean, and which rows are a step.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/known_species.h"
#include "preprocess/readers/tfs/tfs_file.h"

namespace mote::prep {
namespace {

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

/// Which column of ours a column of a track is; "" for those that are none.
std::string canonicalOfTfs(const std::string& name) {
    static const std::map<std::string, std::string> names = {
        {"NUMBER", "id"},  {"X", "x [m]"},    {"PX", "px [p0]"}, {"Y", "y [m]"},
        {"PY", "py [p0]"}, {"T", "late [m]"}, {"PT", "ptau"}};
    const auto found = names.find(name);
    return found == names.end() ? "" : found->second;
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
                if (canonicalOfTfs(file.names[i]).empty()) continue;
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
            if (!canonicalOfTfs(name).empty()) table.names.push_back(canonicalOfTfs(name));
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
